#!/bin/sh
# scripts/check_layers.sh [BUILD] - fails when an #include points upwards. The floors, from the ground: lcp, problems,
# formulations, harness (tests may include anything); library stands on lcp and, of harness, on the verdict and the choice of a solver. It also fails when the judge or the verifier of certificates
# includes a header of the solvers, or a solver one of theirs. Then scripts/check_circles.py looks for circles inside
# folders and between rooms in the objects of BUILD (default: build).
cd "$(dirname "$0")/.." || exit 2
bad=0
deny() { # forbidden include prefixes, folders and files
  forbidden=$1
  shift
  if grep -rnE "#include \"($forbidden)" "$@" --include='*.[ch]'; then bad=1; fi
}
deny 'problems/|formulations/|harness/|library/|tests/' lcp
deny 'formulations/|harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)' problems
deny 'harness/|tests/|lcp/solvers/|lcp/lcp_(solver|instance)|problems/scenes/' formulations
deny 'tests/|library/|lcp/solvers/' harness
deny 'tests/|problems/|formulations/|lcp/solvers/|harness/(util|plan|cell|campaign|check|cli)/' library harness/choice/plugin_solver.* harness/choice/solver_choice.* harness/measure/verdict.*
# Who judges shares with who is judged the problem and the words of a claim, no arithmetic but the
# rounding of a factored M to entries and the geometry of its cone.
judges() { # pattern of the includes that they may have
  grep -n '#include "' lcp/lcp_judge.c lcp/lcp_judge.h lcp/lcp_verify.c lcp/lcp_certificate.h \
    lcp/lcp_wide_column.c lcp/lcp_wide_column.h lcp/lcp_wide_inside.h lcp/lcp_wide_sums.c | grep -vE "$1"
}
theirs='judge|certificate|wide_column|wide_inside'
if judges "\"lcp/(base/[a-z]+|lcp_($theirs|problem|outcome|cone))\.h\""; then bad=1; fi
deny "lcp/lcp_($theirs)" lcp/solvers lcp/linear lcp/lcp_rho.c lcp/lcp_rho.h lcp/lcp_stop.c \
  lcp/lcp_farkas.c lcp/lcp_solver.h
python3 scripts/check_circles.py "${1:-build}" || bad=1
exit $bad
