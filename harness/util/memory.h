/* harness/util/memory.h - what the process has taken of the system's memory, and when it goes back. */
#pragma once

#include <stddef.h>

/* Blocks of so many bytes and more go back whenever they are freed, and what is free at the end of the heap likewise; what is smaller
 * stays and is used again. Without it glibc keeps the more the larger those were that were freed before. Nothing elsewhere. */
void memory_return_from(size_t bytes);

/* The most that this program has had in memory since it began [B], without what the process was before it; NaN where the system does
 * not tell (/proc/self/status). */
double memory_peak(void);
