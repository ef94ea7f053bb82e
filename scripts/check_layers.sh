#!/bin/sh
# scripts/check_layers.sh - fails when an #include points against the data flow
# problems -> formulations -> lcp -> harness (tests may include anything).
cd "$(dirname "$0")/.." || exit 2
bad=0
deny() { # folder, forbidden include prefixes
  if grep -rnE "#include \"($2)" "$1" --include='*.[ch]'; then bad=1; fi
}
deny lcp          'problems/|formulations/|harness/|tests/'
deny problems     'formulations/|harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)'
deny formulations 'harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)|problems/scene\.h'
deny harness      'tests/|lcp/solvers/'
exit $bad
