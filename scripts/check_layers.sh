#!/bin/sh
# scripts/check_layers.sh [BUILD] - fails when an #include points upwards. The floors, from the ground: lcp, problems,
# formulations, harness (tests may include anything). It also fails when the judge or the verifier of certificates
# includes a header of the solvers, or a solver one of theirs. Then scripts/check_circles.py looks for circles inside
# folders and between rooms in the objects of BUILD (default: build).
cd "$(dirname "$0")/.." || exit 2
bad=0
deny() { # folders and files, forbidden include prefixes
  if grep -rnE "#include \"($2)" $1 --include='*.[ch]'; then bad=1; fi
}
deny lcp          'problems/|formulations/|harness/|tests/'
deny problems     'formulations/|harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)'
deny formulations 'harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)|problems/scenes/'
deny harness      'tests/|lcp/solvers/'
# Who judges shares with who is judged the problem and the words of a claim, no arithmetic but the
# rounding of a factored M to entries and the geometry of its cone.
judges='lcp/lcp_judge.c lcp/lcp_judge.h lcp/lcp_verify.c lcp/lcp_certificate.h lcp/lcp_wide_column.c lcp/lcp_wide_column.h'
theirs='judge|certificate|wide_column'
if grep -n '#include "' $judges | grep -vE "\"lcp/(base/[a-z]+|lcp_($theirs|problem|outcome|cone))\.h\""; then bad=1; fi
deny 'lcp/solvers lcp/linear lcp/lcp_rho.c lcp/lcp_rho.h lcp/lcp_stop.c lcp/lcp_farkas.c lcp/lcp_solver.h' "lcp/lcp_($theirs)"
python3 scripts/check_circles.py "${1:-build}" || bad=1
exit $bad
