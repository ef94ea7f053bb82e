#!/bin/sh
# scripts/check_objects.sh BUILD - reads the compiled libraries and fails on what the style forbids:
# printing, exiting, allocating, random numbers or clocks inside solvers; printing to the terminal or exiting in
# any library; writable global data anywhere; global symbols outside the prefixes of their layer.
# Wrappers of foreign libraries that allocate by themselves are named in scripts/allow.txt.
cd "$(dirname "$0")/.." || exit 2
b=${1:?usage: check_objects.sh BUILD}
bad=0
say() { echo "$*"; bad=1; }
calls() { # regular expression, objects: the undefined symbols that match
  re=$1; shift
  nm -A -u "$@" | awk '{print $1, $NF}' | grep -E " ($re)(@.*)?\$"
}

for layer in lcp problems formulations harness; do
  [ -f "$b/$layer/lib$layer.a" ] || { echo "no $b/$layer/lib$layer.a: build first"; exit 2; }
done
solvers=$(find "$b/lcp" -path '*solvers*' -name '*solver_*.c.o' | grep -vFf scripts/allow.txt)
if [ -n "$solvers" ]; then
  # shellcheck disable=SC2086  # a list of files
  calls 'malloc|calloc|realloc|aligned_alloc|free|s?rand|random|time|clock|clock_gettime|gettimeofday' $solvers &&
    say 'forbidden call in lcp/solvers'
fi
calls 'exit|_exit|abort|printf|puts|putchar|perror|stdout|stderr|err|warn|errx|warnx' \
  "$b"/lcp/*.a "$b"/problems/*.a "$b"/formulations/*.a "$b"/library/*.a | grep -vFf scripts/allow.txt &&
  say 'a library prints or exits'
objdump -t "$b"/lcp/*.a "$b"/problems/*.a "$b"/formulations/*.a |
  awk '$NF !~ /^\./ && ($3 ~ /^\.(data|bss)$/ || $4 ~ /^\.(data|bss)$/ || $3 == "*COM*" || $4 == "*COM*") {print; f = 1} END {exit !f}' &&
  say 'writable global data'
own() { # library, prefixes
  nm -g --defined-only "$1" | awk 'NF == 3 {print $3}' | grep -vE "^($2)(_|\$)" && say "foreign prefix in $1"
}
own "$b/lcp/liblcp.a" 'lcp|base|lin|linear|lemke'
own "$b/problems/libproblems.a" 'scenes?|kit|spec|world|contact|effects?|shape|segment|gap|body|broad|pair|detect|loads|joint|joints|model|store|piece|problem|round|survives|case|node|read|known|plant|triplets|generate|family|friction|import|fclib|siconos|lcp_case|lcp_family|lcp_families|name_index'
own "$b/formulations/libformulations.a" 'anderson|boxed|form|formulations?|force|contact_memory|poly|row_form|row_matrix|row_storage|row_assembly|reg|arc|impulse_log|joint_log|penalty|slip|event|space|step|turns|watch'
exit $bad
