/* harness/cell/stats.h - order statistics of repeated measurements. */
#pragma once

/* Sorts x[n] in place, ascending. */
void stats_sort(double *x, int n);

/* Median of sorted x[n]; NaN if n = 0. */
double stats_median(const double *sorted, int n);

/* 95 % confidence interval of the median by order statistics: ranks (n -+ 1.96 sqrt n)/2, the
 * extremes where n is too small for them (n < 6). */
void stats_median_interval(const double *sorted, int n, double *lo, double *hi);

/* Half width of that interval over the median [1]; infinite for n < 2. */
double stats_half_width(double *x, int n);

/* Quantile 0 <= p <= 1 of sorted x[n], linear between ranks. */
double stats_quantile(const double *sorted, int n, double p);
