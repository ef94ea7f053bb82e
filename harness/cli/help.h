/* harness/cli/help.h - what the program says of itself, all from the tables that it is run by: verbs and their
 * options (args.h), components and theirs (fields.h). */
#pragma once

#include "harness/cli/verbs.h"
#include "lcp/base/fields.h"

#include <stdbool.h>
#include <stdio.h>

/* "solve PROBLEM --solver SOLVER [--q FILE] ...": the options that are needed stand without brackets. */
void help_usage(FILE *to, const cli_verb *v);

/* Usage, the sentence, and every option with unit, range and a sentence. */
void help_verb(FILE *to, const cli_verb *v);

/* All verbs, each with its usage and sentence. */
void help_all(FILE *to);

/* Every option of a component: unit, default, range or words, and a sentence. */
void help_fields(FILE *to, const base_field *f, int n);

/* A manual page (section 1, man(7)) of the whole program. */
void help_man(FILE *to);
