/* harness/util/versions.h - content keys of the components: the hash of a component's file and of the folder of
 * its name beside it, made when the build is made. A changed solver invalidates its own cells and no
 * others; a change of what all rows depend on (lcp, formulations, problems, harness/measure, harness/cell)
 * invalidates all. */
#pragma once

/* The solver of a plug-in: its version is the hash of its file, 16 hex digits. */
void version_add_solver(const char *name, const char *hash);

/* 16 hex digits, or "external" for components outside lcp/solvers, formulations, problems/scenes. */
const char *version_of_solver(const char *name);
const char *version_of_formulation(const char *name);
const char *version_of_scene(const char *name);
const char *version_of_family(const char *name);

const char *build_commit(void); /* git commit, or "unknown" */
int build_dirty(void);          /* 1: the tree had changes, 0: clean, -1: unknown */
const char *build_compiler(void);
const char *build_options(void);
const char *build_base(void); /* 16 hex digits over compiler, options and shared sources */
const char *build_hash(void); /* 16 hex digits over compiler, options and every component */
