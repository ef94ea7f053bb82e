#include "harness/control/repeat.h"

#include "harness/choice/plugins.h"

#include <stdio.h>

/* A name that begins with a dash would be an option; "-" alone is standard input. */
static void put_scene(shell_line *l, const char *scene) {
  const bool dash = scene[0] == '-' && scene[1] != '\0';
  shell_put(l, dash ? "./" : "");
  shell_put_word(l, scene);
}

void repeat_run(shell_line *l, const simulation_texts *t, const char *form, const char *solver,
                const char *effects) {
  const plugin_file *f;
  shell_put(l, "lcpbench simulate ");
  put_scene(l, t->scene);
  for (int i = 0; (f = plugins_at(i)) != NULL; i++) {
    shell_put_option(l, "plugin", f->path);
  }
  shell_put_option(l, "formulation", form);
  shell_put_option(l, "solver", solver);
  shell_put_option(l, "tol", t->tol);
  shell_put_option(l, "duration", t->duration);
  shell_put_option(l, "start", t->start);
  shell_put_option(l, "contact-order", t->contact_order);
  shell_put_option(l, "islands", t->islands);
  shell_put_option(l, "threads", t->threads);
  shell_put_option(l, "memory", t->memory);
  shell_put_option(l, "effects", effects);
}

void repeat_error(shell_line *l, const simulation_texts *t, const error_asked *asked) {
  char error[64];
  (void)snprintf(error, sizeof error, "%.17g%s", asked->E, asked->unit);
  shell_put_option(l, "step", t->step);
  shell_put_option(l, "error", error);
  shell_put_option(l, "work", t->work);
  shell_put_option(l, "time-limit", t->time_limit);
}
