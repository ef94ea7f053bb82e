/* harness/util/table.h - flat JSON objects of one kind as a table: in words for a terminal, as CSV, or as they are. */
#pragma once

#include "lcp/base/status.h"

#include <jansson.h>
#include <stdbool.h>
#include <stdio.h>

enum { TABLE_COLUMNS = 32 };

/* Is it "table", "csv" or "json"? BASE_EINVAL names --format otherwise, and what was probably meant. */
base_status table_format(const char *format, base_error *err);

/* Prints the rows (an array of objects, given back to jansson). column: keys of the objects in their order, ended by
 * NULL, at most TABLE_COLUMNS; of json the whole objects are printed. In words, numbers stand right, reals have three
 * digits and null is -; in CSV (RFC 4180) reals have 17 digits and null is empty. False: it could not be written. */
bool table_print(json_t *rows, const char *const *column, const char *format, FILE *to);
