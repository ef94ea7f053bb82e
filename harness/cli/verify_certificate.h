/* harness/cli/verify_certificate.h - the certificate of a problem checked without a solver. */
#pragma once

/* Prints one JSON object on stdout; CLI_OK where the certificate holds, CLI_HONEST where it does not,
 * else the exit code of the error reported. problem, q, facets: as problem_source_open takes them. */
int verify_certificate(const char *problem, const char *q, int facets, const char *path);
