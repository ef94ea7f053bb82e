/* lcp_plugin.h - a solver of one's own, as a shared object that lcpbench loads: `--plugin FILE.so`, or LCPBENCH_PLUGINS.
 *
 * A plug-in includes this header and nothing else of the project, links with nothing of it, and exports one constant:
 *
 *   const lcp_plugin lcp_plugin_descriptor = {LCP_PLUGIN_ABI, sizeof(lcp_plugin), .name = "mine", ...};
 *
 * From then on it is a solver like any other: in every verb and campaign, in a process of its own with limits, and judged from the
 * data alone. It posts z and a claim; a wrong claim becomes a row `unverified`, a crash a row `crash`, a hang a row `timeout`.
 * `lcpbench conform FILE.so` tries it on everything that it declares. The content hash of the file is its version.
 *
 *   find z, w in R^n:   w = M z + q,   z in K,   w in K*,   z _|_ w
 *
 * A plug-in prints nothing, does not exit, keeps no state but in its workspace, and writes to nothing but that and what it is
 * given to write to.
 */
#ifndef LCP_PLUGIN_H
#define LCP_PLUGIN_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ## Words */

/* The interface of this header. A host refuses a plug-in of another number. */
#define LCP_PLUGIN_ABI 1

/* Sets of rows: bits of lcp_plugin.sets, and the set of a block. */
enum {
  LCP_PLUGIN_ORTHANT = 1, /* z_i >= 0 */
  LCP_PLUGIN_BOX = 2,     /* lo_i <= z_i <= hi_i; w_i > 0 only at lo_i, w_i < 0 only at hi_i */
  LCP_PLUGIN_FREE = 4,    /* z_i unbounded, w_i = 0 */
  LCP_PLUGIN_CONE = 8     /* |z_k| <= mu_k z_n for each part, exact Coulomb law */
};

/* Storages of M: bits of lcp_plugin.storages. What a plug-in does not read is converted, and the conversion charged to set-up. */
enum { LCP_PLUGIN_DENSE = 1, LCP_PLUGIN_CSC = 2 };

/* What may be known of M: bits of lcp_plugin.needs and lcp_plugin_problem.traits. */
enum {
  LCP_PLUGIN_SYMMETRIC = 1,
  LCP_PLUGIN_PSD = 2,
  LCP_PLUGIN_PD = 4,
  LCP_PLUGIN_COPOSITIVE = 8,
  LCP_PLUGIN_COPOSITIVE_PLUS = 16,
  LCP_PLUGIN_P_MATRIX = 32
};

/* What lcp_plugin.solve returns: what the plug-in claims. Only LCP_PLUGIN_SOLVED and _INFEASIBLE are checked for truth, the others
 * are believed. The last two are no claims: prepare returns them, too. */
enum {
  LCP_PLUGIN_AS_STOPPED = 0, /* what stop() found when it returned 1 */
  LCP_PLUGIN_SOLVED = 1,
  LCP_PLUGIN_MAX_ITER = 2,
  LCP_PLUGIN_TIME_LIMIT = 3,
  LCP_PLUGIN_STALLED = 4,    /* no progress */
  LCP_PLUGIN_RAY = 5,        /* ended on a ray that proves nothing */
  LCP_PLUGIN_INFEASIBLE = 6, /* with lcp_plugin_result.farkas */
  LCP_PLUGIN_NUMERICAL = 7,  /* a factorisation broke down, NaN */
  LCP_PLUGIN_NO_MEMORY = 8,
  LCP_PLUGIN_FAILED = 9 /* the library below reported an error */
};

/* What lcp_plugin.prepare returns, beside LCP_PLUGIN_NO_MEMORY and LCP_PLUGIN_FAILED. */
enum { LCP_PLUGIN_READY = 0, LCP_PLUGIN_UNSUPPORTED = 1 };

/* Room for the one line that prepare may leave. */
#define LCP_PLUGIN_MESSAGE 200

/* ## The problem */

/* Rows that belong together. A cone has z = (z_n, parts), each part of part_dim rows with coefficient part_mu: sliding friction,
 * then torsion and rolling where there are any; size = 1 + their sum. */
typedef struct lcp_plugin_block {
  int set; /* LCP_PLUGIN_ORTHANT, ... */
  int start, size;
  int n_part; /* of a cone, at most 3 */
  int part_dim[3];
  double part_mu[3];
} lcp_plugin_block;

/* The problem, read-only, the same from prepare to the solves that follow. */
typedef struct lcp_plugin_problem {
  int n;
  const double *dense; /* n*n by columns; NULL where M is sparse */
  const int *colptr;   /* n+1; NULL where M is dense; row indices increase inside a column */
  const int *rowind;
  const double *val;
  const double *q; /* n */
  const double
      *lo; /* n, of every row: 0 and HUGE_VAL on an orthant, infinite on free rows and cones */
  const double *hi;
  int n_block;
  const lcp_plugin_block *block; /* in order, covering all rows */
  unsigned traits;
} lcp_plugin_problem;

/* ## A solve */

/* What the host hands over with a solve. */
typedef struct lcp_plugin_call {
  void *host;         /* for stop and trace */
  double tol;         /* the residual rho to reach [1] */
  int max_iter;       /* iterations allowed */
  double max_seconds; /* time allowed [s] */
  const double
      *option; /* values of lcp_plugin.options, in their order; of a choice the index of the word */

  /* The test that all iterative solvers of the suite share, at z after so many iterations: 1 where the solve must end, solved or
   * at a limit; then solve returns LCP_PLUGIN_AS_STOPPED. Costs a product with M, every check_every iterations. */
  int (*stop)(void *host, long iterations, const double *z);

  /* For methods with a residual of their own: a point of the convergence history [1]. Nothing happens in timed runs. */
  void (*trace)(void *host, long iterations, double residual);
} lcp_plugin_call;

/* What a solve counted; all zero on entry. */
typedef struct lcp_plugin_result {
  long iterations, pivots, matvecs, factorizations;
  double residual;      /* the plug-in's own estimate of rho; 0: none */
  const double *farkas; /* n, in the workspace: y >= 0, M'y <= 0, q'y < 0 proves infeasibility */
} lcp_plugin_result;

/* ## The descriptor */

/* An option of the solver, in the command line "NAME:option=value". tol, max_iter, check_every and max_seconds are always there. */
typedef struct lcp_plugin_option {
  const char *name;             /* lower case, digits, _ */
  const char *unit;             /* "1", "s", ... */
  const char *kind;             /* "int", "real" or "choice" */
  double standard, least, most; /* of a choice: the index of the default word, and unused */
  const char *words;            /* of a choice: "first|second"; else NULL */
  const char *help;             /* one sentence */
} lcp_plugin_option;

/* What a plug-in is. */
typedef struct lcp_plugin {
  int abi;     /* LCP_PLUGIN_ABI */
  size_t size; /* sizeof(lcp_plugin), as the plug-in was compiled */
  const char *
      name; /* as the command line and rows have it: lower case, digits, _; no solver of that name may exist */
  const char *title; /* what the field calls the method */
  const char *words; /* one sentence: what it is */
  const char *when;  /* one sentence: when to take it */
  unsigned sets;     /* that it solves */
  unsigned storages; /* that it reads */
  unsigned needs;    /* traits without which it is not asked */
  int exact;         /* 1: a direct method, judged at rho 1e-9; 0: at 1e-6 */
  int warm;          /* 1: uses z as it comes in */
  double tol;        /* default of the option tol; 0: 1e-8 */
  int max_iter;      /* default of the option max_iter; 0: 10000 */

  const lcp_plugin_option *options;
  int n_option;

  /* Bytes of workspace for a problem of n rows, `entries` stored numbers of M and n_block blocks: memory, aligned to 64 bytes and not
   * cleared, that prepare and solve receive. NULL: none. */
  size_t (*workspace)(int n, size_t entries, int n_block, const double *option);

  /* What depends on the problem and is done once before its solves; timed as set-up. Where it returns other than LCP_PLUGIN_READY it
   * leaves one line in message. NULL: nothing to do. */
  int (*prepare)(void *work, const lcp_plugin_problem *p, const double *option,
                 char message[LCP_PLUGIN_MESSAGE]);

  /* z[n]: the start point on entry (zeros when cold), the last iterate on return, whatever came of it. */
  int (*solve)(void *work, const lcp_plugin_problem *p, const lcp_plugin_call *call, double *z,
               lcp_plugin_result *result);

  /* Gives back what prepare and solve took from elsewhere; called once for each prepare. NULL: a plug-in that takes nothing. */
  void (*release)(void *work);
} lcp_plugin;

/* The one symbol that a plug-in exports; hidden as the rest may be by the compiler's -fvisibility=hidden. */
extern
#if defined(__GNUC__)
    __attribute__((visibility("default")))
#endif
    const lcp_plugin lcp_plugin_descriptor;

#ifdef __cplusplus
}
#endif
#endif
