/* lcpbench calibrate: the regularisation of one scene that reaches an error in the least time. */
#include "harness/cli/calibrate.h"
#include "harness/cli/cli.h"
#include "harness/measure/predictions.h"
#include "harness/measure/registry.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/shell.h"

#include <string.h>

typedef struct calibrate_options {
  const char *formulation, *solver, *error, *step, *yardstick;
  int evaluations;
} calibrate_options;

/* What the options choose; owns everything. */
typedef struct calibration {
  const char *text; /* the scene as given */
  scene_spec spec;
  formulation_choice form;
  solver_choice solver;
  calibrate_task task;
  double rule[2]; /* where the search begins */
} calibration;

static base_status positive(const char *name, const char *text, double *out, base_error *err) {
  if (!base_parse_real(text, out) || !(*out > 0.0)) {
    return BASE_FAIL(err, BASE_EINVAL, "%s %s: need a number above 0", name, text);
  }
  return BASE_OK;
}

/* Value of an option in "a=1,b=2,..." text; the formulation's own default if it is not there. */
static double option_of(const char *config, const char *name) {
  const size_t len = strlen(name);
  for (const char *at = config; at != NULL && *at != '\0'; at = strchr(at, ',')) {
    at += (*at == ',');
    double value;
    char text[40];
    if (strncmp(at, name, len) == 0 && at[len] == '=') {
      (void)snprintf(text, sizeof text, "%.*s", (int)strcspn(at + len + 1, ","), at + len + 1);
      return base_parse_real(text, &value) ? value : (double)NAN;
    }
  }
  return (double)NAN;
}

static base_status choose_parameters(calibration *c, base_error *err) {
  const bool fixed = strstr(c->form.config, "stiffness=fixed") != NULL;
  if (!formulation_choice_has(&c->form, "ratio")) {
    return BASE_FAIL(err, BASE_EINVAL, "--formulation %s: has no regularisation to calibrate",
                     c->form.form->name);
  }
  c->task.name[0] = fixed ? "k" : "ratio";
  c->task.name[1] = fixed ? "c" : "zeta";
  for (int i = 0; i < 2; i++) {
    c->rule[i] = option_of(c->form.config, c->task.name[i]);
    if (!(c->rule[i] > 0.0)) {
      return BASE_FAIL(err, BASE_EINVAL, "--formulation: %s = %g: the search needs a start above 0",
                       c->task.name[i], c->rule[i]);
    }
  }
  return BASE_OK;
}

static base_status choose(const calibrate_options *o, const char *text, calibration *c,
                          base_error *err) {
  calibrate_task *t = &c->task;
  c->text = text;
  BASE_TRY(
      formulation_choose(o->formulation != NULL ? o->formulation : "regularized", &c->form, err));
  BASE_TRY(solver_choose(o->solver != NULL ? o->solver : "lemke", &c->solver, err));
  BASE_TRY(scene_open(text, &c->spec, err));
  BASE_TRY(positive("--error", o->error, &t->level, err));
  t->first = fmin(0.05, c->spec.duration);
  if (o->step != NULL) {
    BASE_TRY(positive("--step", o->step, &t->first, err));
    BASE_TRY(sim_check_times(t->first, c->spec.duration, err));
  }
  const char *yardstick = (o->yardstick != NULL) ? o->yardstick : "trajectory";
  if (strcmp(yardstick, "trajectory") != 0 && strcmp(yardstick, "physical") != 0) {
    return BASE_FAIL(err, BASE_EINVAL, "--yardstick %s: need trajectory or physical", yardstick);
  }
  t->yardstick = (strcmp(yardstick, "physical") == 0) ? CALIBRATE_PHYSICAL : CALIBRATE_TRAJECTORY;
  t->evaluations = (o->evaluations > 0) ? o->evaluations : 40;
  t->form = &c->form;
  t->request = (sim_request){.spec = &c->spec,
                             .form = &c->form,
                             .solver = &c->solver,
                             .effects = c->spec.effects,
                             .duration = c->spec.duration,
                             .start = FORM_COLD};
  if (t->yardstick == CALIBRATE_TRAJECTORY && !prediction_exists(&t->request)) {
    return BASE_FAIL(err, BASE_EINVAL,
                     "%.200s: predicts nothing to calibrate against; --yardstick physical needs no "
                     "prediction",
                     text);
  }
  return choose_parameters(c, err);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

/* The command of a point, with every option that the search ran with. */
static base_status command_of(calibration *c, const calibrate_point *p, char *buf, size_t cap,
                              base_error *err) {
  char text[4 * 1024 + 64]; /* every letter escaped */
  BASE_TRY(calibrate_set(&c->task, p->x, err));
  (void)shell_quote(c->text, text, sizeof text);
  (void)snprintf(
      buf, cap, "lcpbench simulate %s --formulation '%s:%s' --solver '%s:%s' --step '%.17g'", text,
      c->form.form->name, c->form.config, c->solver.solver->name, c->solver.config, p->h);
  return BASE_OK;
}

static base_status put_point(json_t *o, const char *key, calibration *c, const calibrate_point *p,
                             base_error *err) {
  char command[2 * CHOICE_CONFIG + 4 * 1024 + 300];
  BASE_TRY(command_of(c, p, command, sizeof command, err));
  json_t *one = json_object();
  for (int i = 0; i < 2; i++) {
    json_out_real(one, c->task.name[i], p->x[i]);
  }
  json_out_bool(one, "reaches", p->reaches);
  json_out_real(one, "error", p->error);
  json_out_real(one, "step_s", p->reaches ? p->h : (double)NAN);
  json_out_real(one, "t_total_s", p->reaches ? p->seconds : (double)NAN);
  json_out_text(one, "command", p->reaches ? command : "");
  (void)json_object_set_new(o, key, one);
  return BASE_OK;
}

static base_status to_json(calibration *c, const calibrate_result *r, json_t *o, base_error *err) {
  json_out_text(o, "scene", c->text);
  json_out_text(o, "formulation", c->form.form->name);
  json_out_text(o, "solver", c->solver.solver->name);
  json_out_real(o, "error", c->task.level);
  json_out_text(o, "yardstick",
                c->task.yardstick == CALIBRATE_PHYSICAL ? "physical" : "trajectory");
  BASE_TRY(put_point(o, "rule", c, &r->rule, err));
  BASE_TRY(put_point(o, "best", c, &r->best, err));
  json_out_real(o, "gain", r->gain);
  json_out_int(o, "evaluations", r->evaluations);
  json_out_int(o, "simulations", r->simulations);
  return BASE_OK;
}

static base_status print_result(calibration *c, const calibrate_result *r, int *code,
                                base_error *err) {
  json_t *o = json_object();
  const base_status done = to_json(c, r, o, err);
  if (done != BASE_OK) {
    json_decref(o);
    return done;
  }
  *code = !json_out_print(o, stdout) ? CLI_INTERNAL : r->best.reaches ? CLI_OK : CLI_HONEST;
  return BASE_OK;
}

/* ---- verb ------------------------------------------------------------------------------------ */

static const arg_option options[] = {
    ARG(calibrate_options, formulation, "--formulation", ARG_TEXT, "FORMULATION",
        "regularized formulation whose parameters are searched"),
    ARG(calibrate_options, solver, "--solver", ARG_TEXT, "SOLVER",
        "solver of its problems; lemke where none is given"),
    ARG(calibrate_options, error, "--error", ARG_TEXT, "E",
        "error to stay below, in the unit of the yardstick", .needed = true, .unit = "m, rad or 1",
        .above = true),
    ARG(calibrate_options, step, "--step", ARG_TEXT, "H",
        "longest step that is tried; 0.05 where none is given", .unit = "s", .above = true),
    ARG(calibrate_options, yardstick, "--yardstick", ARG_TEXT, "trajectory|physical",
        "error of the predicted motion, or the physical residual of the steps"),
    ARG(calibrate_options, evaluations, "--evaluations", ARG_INT, "N",
        "pairs of parameters that are tried at most; 40 where none is given", .unit = "1",
        .min = 1),
};
static const arg_table args = {
    options, BASE_COUNT(options), 1, 1, "SCENE", "scene with its parameters, or scene file"};

static int run(int argc, char **argv) {
  calibrate_options o = {0};
  const char *text;
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &text, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  calibration c = {0};
  calibrate_result r;
  spec_init(&c.spec);
  int code = CLI_INTERNAL;
  base_status done = choose(&o, text, &c, &err);
  if (done == BASE_OK) {
    done = calibrate(&c.task, c.rule, &r, &err);
  }
  if (done == BASE_OK) {
    done = print_result(&c, &r, &code, &err);
  }
  spec_free(&c.spec);
  formulation_choice_free(&c.form);
  solver_choice_free(&c.solver);
  return (done == BASE_OK) ? code : cli_report(&err);
}

extern const cli_verb verb_calibrate;
const cli_verb verb_calibrate = {
    .name = "calibrate",
    .args = &args,
    .help = "finds the regularisation (ratio, zeta; k, c with stiffness=fixed) and the step that"
            " keep the error in the least time, and prints the gain over the rule of thumb",
    .run = run,
};
