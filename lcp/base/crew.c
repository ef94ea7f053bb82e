#include "lcp/base/crew.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

struct base_crew {
  int size; /* threads, that of the caller included */
  pthread_t helper[BASE_THREADS_MAX];
  pthread_mutex_t lock;
  pthread_cond_t called, left;
  /* under the lock */
  long work;   /* number of the last one */
  bool open;   /* it may be joined */
  bool closed; /* there will be none any more */
  int inside;  /* helpers in it */
  int arrived; /* helpers that have begun to live */
  /* of the work; written before it is opened */
  base_part part;
  void *context;
  int parts;
  atomic_int next;
};

static _Thread_local base_crew *mine;

/* Parts until none is left. */
static void take_part(base_crew *c, int hand) {
  for (;;) {
    const int k = atomic_fetch_add(&c->next, 1);
    if (k >= c->parts) {
      return;
    }
    c->part(c->context, k, hand);
  }
}

static void *help(void *crew) {
  base_crew *c = crew;
  long seen = 0;
  (void)pthread_mutex_lock(&c->lock);
  const int hand = ++c->arrived;
  for (;;) {
    while (!c->closed && !(c->open && c->work != seen)) {
      (void)pthread_cond_wait(&c->called, &c->lock);
    }
    if (c->closed) {
      (void)pthread_mutex_unlock(&c->lock);
      return NULL;
    }
    seen = c->work;
    c->inside++;
    (void)pthread_mutex_unlock(&c->lock);
    take_part(c, hand);
    (void)pthread_mutex_lock(&c->lock);
    if (--c->inside == 0) {
      (void)pthread_cond_signal(&c->left);
    }
  }
}

base_status base_crew_open(base_crew **out, int threads, base_error *err) {
  base_crew *c = calloc(1, sizeof *c);
  *out = c;
  if (c == NULL) {
    return BASE_FAIL(err, BASE_ENOMEM, "no memory for %d threads", threads);
  }
  (void)pthread_mutex_init(&c->lock, NULL);
  (void)pthread_cond_init(&c->called, NULL);
  (void)pthread_cond_init(&c->left, NULL);
  c->size = 1;
  while (c->size < threads && pthread_create(&c->helper[c->size], NULL, help, c) == 0) {
    c->size++;
  }
  return BASE_OK;
}

void base_crew_close(base_crew *c) {
  if (c == NULL) {
    return;
  }
  (void)pthread_mutex_lock(&c->lock);
  c->closed = true;
  (void)pthread_cond_broadcast(&c->called);
  (void)pthread_mutex_unlock(&c->lock);
  for (int k = 1; k < c->size; k++) {
    (void)pthread_join(c->helper[k], NULL);
  }
  (void)pthread_cond_destroy(&c->left);
  (void)pthread_cond_destroy(&c->called);
  (void)pthread_mutex_destroy(&c->lock);
  free(c);
}

base_crew *base_crew_take_up(base_crew *c) {
  base_crew *before = mine;
  mine = c;
  return before;
}

int base_crew_size(void) {
  return (mine != NULL) ? mine->size : 1;
}

/* A helper that comes late finds the work closed. */
static void share_with(base_crew *c, int parts, base_part part, void *context) {
  (void)pthread_mutex_lock(&c->lock);
  c->part = part;
  c->context = context;
  c->parts = parts;
  atomic_store(&c->next, 0);
  c->work++;
  c->open = true;
  (void)pthread_cond_broadcast(&c->called);
  (void)pthread_mutex_unlock(&c->lock);
  take_part(c, 0);
  (void)pthread_mutex_lock(&c->lock);
  c->open = false;
  while (c->inside > 0) {
    (void)pthread_cond_wait(&c->left, &c->lock);
  }
  (void)pthread_mutex_unlock(&c->lock);
}

void base_share(int parts, base_part part, void *context) {
  if (parts > 1 && base_crew_size() > 1) {
    base_crew *crew = base_crew_take_up(NULL);
    share_with(crew, parts, part, context);
    (void)base_crew_take_up(crew);
    return;
  }
  for (int k = 0; k < parts; k++) {
    part(context, k, 0);
  }
}
