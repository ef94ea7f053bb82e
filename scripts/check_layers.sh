#!/bin/sh
# scripts/check_layers.sh [BUILD] - fails when an #include points upwards. The floors, from the ground: lcp, problems,
# formulations, harness (tests may include anything). Then scripts/check_circles.py looks for circles inside
# folders and between rooms in the objects of BUILD (default: build).
cd "$(dirname "$0")/.." || exit 2
bad=0
deny() { # folder, forbidden include prefixes
  if grep -rnE "#include \"($2)" "$1" --include='*.[ch]'; then bad=1; fi
}
deny lcp          'problems/|formulations/|harness/|tests/'
deny problems     'formulations/|harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)'
deny formulations 'harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)|problems/scene\.h'
deny harness      'tests/|lcp/solvers/'
python3 scripts/check_circles.py "${1:-build}" || bad=1
exit $bad
