/* harness/util/csv.h - cells of CSV files (RFC 4180). */
#pragma once

#include <stdio.h>

/* Gives put the letters of a cell one by one: the text as it is, or in quotes, with those in it doubled, where it holds a comma, a
 * quote or a line break. */
void csv_cell(const char *text, void (*put)(void *to, char c), void *to);

/* The same into a file. */
void csv_put(const char *text, FILE *to);
