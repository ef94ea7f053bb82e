/* lcpbench simulate: one scene, one formulation, one solver, one JSON object. */
#include "harness/cli/cli.h"
#include "harness/control/repeat.h"
#include "harness/control/simulation.h"
#include "harness/measure/predictions.h"
#include "harness/measure/trace.h"
#include "harness/util/args.h"
#include "harness/util/json_out.h"
#include "harness/util/memory.h"
#include "harness/util/stop.h"
#include "lcp/base/crew.h"
#include "lcp/base/output.h"
#include "problems/world/world.h"
#include "problems/write/scene_write.h"

#include <math.h>
#include <string.h>

/* ---- JSON ------------------------------------------------------------------------------------ */

static json_t *observables(const series *record) {
  json_t *all = json_object();
  for (int i = 0; i < record->n_var; i++) {
    const series_var *v = &record->var[i];
    spec_check c = {.has_dir = v->has_dir};
    memcpy(c.dir, v->dir, sizeof c.dir);
    char name[128];
    (void)snprintf(name, sizeof name, "%s", v->var);
    if (v->has_dir) {
      (void)snprintf(name, sizeof name, "%s[%.4g,%.4g,%.4g]", v->var, v->dir[0], v->dir[1],
                     v->dir[2]);
    }
    json_t *one = json_object();
    json_out_real(one, "value", record->column[v->column][record->n_row - 1]);
    json_out_text(one, "unit", world_observe_unit(v->var));
    (void)json_object_set_new(all, name, one);
  }
  json_t *energy = json_object();
  json_out_real(energy, "value", record->column[SERIES_ENERGY][record->n_row - 1]);
  json_out_text(energy, "unit", "J");
  (void)json_object_set_new(all, "energy", energy);
  return all;
}

static json_t *prediction(const spec_check *c, const check_context *ctx, bool *ok) {
  check_result r;
  check_evaluate(c, ctx, &r);
  *ok = r.ok;
  char label[200];
  check_label(c, label, sizeof label);
  json_t *o = json_object();
  json_out_text(o, "quantity", label);
  json_out_real(o, "time_s", r.time);
  json_out_real(o, "value", r.known ? r.got : HUGE_VAL);
  json_out_real(o, "predicted", r.expected);
  json_out_real(o, "error", r.known ? r.error : HUGE_VAL);
  json_out_real(o, "tolerance", r.tolerance);
  json_out_bool(o, "ok", r.ok);
  json_out_text(o, "source", c->source);
  if (r.reason[0] != '\0') {
    json_out_text(o, "reason", r.reason);
  }
  return o;
}

/* Checks belong to the scene as declared; with less than that they are not predictions. */
static json_t *predictions(const simulation *s, const series *record, const sim_result *r,
                           bool *all_ok) {
  const check_context ctx = prediction_context(&s->request, record, r);
  json_t *all = json_array();
  *all_ok = true;
  for (int i = 0; i < s->spec.n_check; i++) {
    bool ok;
    if (prediction_applies(&s->request, i)) {
      (void)json_array_append_new(all, prediction(&s->spec.check[i], &ctx, &ok));
      *all_ok = *all_ok && ok;
    }
  }
  return all;
}

/* The trajectory yardstick, the same quantity for every formulation, and what the run ends with. */
static json_t *yardstick(const simulation *s, const series *record, const sim_result *r) {
  prediction_summary p;
  predictions_summarise(&s->request, record, r, &p);
  json_t *o = json_object();
  if (p.has_ref) {
    json_out_text(o, "quantity", p.quantity);
    json_out_real(o, "error", p.error);
    json_out_real(o, "predicted", p.predicted);
    json_out_text(o, "source", p.source);
  }
  if (p.has_end) {
    json_out_text(o, "end_quantity", s->spec.observe[0]);
    json_out_real(o, "end_value", p.end);
  }
  return o;
}

static void put_effects(json_t *o, const char *key, unsigned mask) {
  char text[256];
  effects_print(mask, text, sizeof text);
  json_out_text(o, key, text);
}

/* What --effects auto:E decided; `repeat` is the --effects of the same run without it. */
static void put_auto(json_t *o, const simulation *s) {
  if (!(s->watch > 0.0)) {
    return;
  }
  const watch_result *w = &s->watched;
  char text[EFFECTS_TEXT];
  json_t *a = json_object();
  json_out_real(a, "level", w->level);
  put_effects(a, "dropped", w->watched & ~effects_plan_union(&w->plan));
  json_out_real(a, "bound", w->bound);
  json_out_real(a, "size_m", w->size);
  json_out_real(a, "speed_m_s", w->speed);
  json_out_int(a, "steps_repeated", w->repeated);
  watch_print(w, s->spec.effects, text);
  json_out_text(a, "why", text);
  effects_plan_print(&w->plan, s->spec.effects, text);
  json_out_text(a, "repeat", text);
  (void)json_object_set_new(o, "effects_auto", a);
}

/* What --error asked for and got. */
static void put_error(json_t *o, const simulation *s) {
  const error_result *r = &s->found;
  if (!(s->error.E > 0.0)) {
    return;
  }
  json_t *e = json_object();
  json_out_real(e, "asked", r->asked.E);
  json_out_text(e, "method", r->extrapolated ? "extrapolated steps" : "plain steps");
  json_out_text(e, "why_plain", r->why_plain);
  json_out_text(e, "unit", r->asked.unit[0] != '\0' ? r->asked.unit : "of the scale");
  json_out_real(e, "err_estimate", r->estimate);
  json_out_bool(e, "promised", r->promised);
  json_out_text(e, "reason", r->reason);
  json_out_int(e, "steps_solved", r->solved);
  json_out_int(e, "steps_limit", r->asked.limit);
  json_out_real(e, "time_limit_s", r->asked.seconds > 0.0 ? r->asked.seconds : HUGE_VAL);
  json_t *all = json_object();
  for (int i = 0; i < FEATURES; i++) {
    json_out_real(all, features_name(i), s->features.x[i]);
  }
  (void)json_object_set_new(e, "features", all);
  all = json_array();
  for (int i = 0; i < r->n_quantity; i++) {
    const error_quantity *q = &r->quantity[i];
    json_t *one = json_object();
    json_out_text(one, "quantity", q->name);
    json_out_real(one, "value", q->value);
    json_out_real(one, "err_estimate", q->estimate);
    json_out_real(one, "scale", q->scale);
    json_out_text(one, "unit", q->unit);
    (void)json_array_append_new(all, one);
  }
  (void)json_object_set_new(e, "quantities", all);
  all = json_array();
  for (int i = 0; i < r->n_level; i++) {
    const error_level *l = &r->level[i];
    json_t *one = json_object();
    json_out_real(one, "tolerance_m", l->tolerance);
    json_out_real(one, "change_over_asked", l->change);
    json_out_int(one, "steps_solved", l->account.solved);
    json_out_int(one, "steps_rejected", l->account.rejected);
    json_out_int(one, "steps_forced", l->account.forced);
    json_out_real(one, "step_min_s", l->account.least);
    json_out_real(one, "step_max_s", l->account.most);
    json_out_real(one, "off_m", l->account.off);
    json_out_real(one, "located_m", l->account.located);
    json_out_real(one, "order_m", l->account.doubt);
    json_out_real(one, "law_m", l->account.law + l->account.left);
    json_out_real(one, "t_total_s", l->seconds);
    (void)json_array_append_new(all, one);
  }
  (void)json_object_set_new(e, "runs", all);
  (void)json_object_set_new(o, "error", e);
}

/* The command of the same run with nothing automatic in it but, without a file of steps, the steps. A run that ended before its time has
 * steps up to there. */
static void put_repeat(json_t *o, const char *key, const simulation *s, const simulation_texts *t,
                       const char *steps) {
  const choice *c = &s->choice;
  char text[8192];
  char effects[EFFECTS_TEXT];
  char duration[32];
  shell_line l = {text, sizeof text, 0};
  simulation_texts own = *t;
  bool whole;
  const double sum = step_list_length(&s->steps, s->request.duration, &whole);
  const bool there = steps != NULL && s->steps.n > 0; /* none where a limit came first */
  if (there && !whole) {
    (void)snprintf(duration, sizeof duration, "%.17g", sum);
    own.duration = duration;
  }
  effects_plan_print(&s->watched.plan, s->spec.effects, effects);
  repeat_run(&l, &own, s->chooses ? c->candidate[s->taken].formulation : t->formulation,
             s->chooses ? c->candidate[s->taken].solver : t->solver,
             s->watch > 0.0 ? effects : t->effects);
  if (there) {
    shell_put_option(&l, "steps", steps);
  } else if (s->error.E > 0.0) {
    repeat_error(&l, t, &s->error);
  } else {
    shell_put_option(&l, "step", t->step);
    shell_put_option(&l, "steps", t->steps);
  }
  json_out_text(o, key, text);
}

/* What chose formulation and solver, and the command that chooses nothing. */
static void put_choice(json_t *o, const simulation *s, const simulation_texts *t,
                       const char *steps) {
  const choice *c = &s->choice;
  if (s->watch > 0.0) {
    put_repeat(json_object_get(o, "effects_auto"), "command", s, t, steps);
  }
  if (s->error.E > 0.0) {
    put_repeat(json_object_get(o, "error"), "command", s, t, steps);
  }
  if (!s->chooses) {
    return;
  }
  json_t *a = json_object();
  json_out_text(a, "rows", c->rows);
  json_out_int(a, "scenes", c->n_scene);
  json_t *list = json_array();
  for (int i = 0; i < c->n_near; i++) {
    json_t *one = json_object();
    json_out_text(one, "near", c->near[i]);
    json_out_real(one, "distance", c->distance[i]);
    (void)json_array_append_new(list, one);
  }
  (void)json_object_set_new(a, "nearest", list);
  list = json_array();
  for (int i = 0; i < c->n; i++) {
    json_t *one = json_object();
    json_out_text(one, "formulation", c->candidate[i].formulation);
    json_out_text(one, "solver", c->candidate[i].solver);
    json_out_real(one, "cost", c->candidate[i].cost);
    json_out_real(one, "sure", c->candidate[i].sure);
    json_out_text(one, "tried", i < s->n_tried ? run_status_name(s->tried[i]) : "");
    (void)json_array_append_new(list, one);
  }
  (void)json_object_set_new(a, "candidates", list);
  put_repeat(a, "repeat", s, t, steps);
  (void)json_object_set_new(o, "choice", a);
}

static void put_memory(json_t *o, const sim_request *q) {
  if (q->least_memory) {
    json_out_text(o, "memory", "least");
  }
  json_out_real(o, "rss_peak_B", memory_peak());
}

/* Of runs that were asked for them. */
static void put_islands(json_t *o, const sim_request *q, const sim_result *r) {
  if (q->islands || q->threads > 1) {
    json_out_int(o, "threads", q->threads);
  }
  if (q->islands) {
    json_out_int(o, "n_island", r->n_island);
    json_out_int(o, "largest_island", r->largest_island);
  }
}

static void put_sleep(json_t *o, const sim_request *q, const sim_result *r) {
  if (q->sleep) {
    json_out_int(o, "n_asleep_max", r->n_asleep_max);
    json_out_int(o, "n_asleep", r->n_asleep);
  }
}

static void put_counts(json_t *o, const sim_result *r) {
  json_out_int(o, "lcp_dim_max", r->lcp_dim_max);
  json_out_int(o, "n_contact_max", r->n_contact_max);
  json_out_int(o, "n_active_max", r->n_active_max);
  json_out_int(o, "n_body", r->n_body);
  json_out_int(o, "n_dof", r->n_dof);
  json_out_int(o, "n_solves", r->n_solves);
  json_out_int(o, "n_unsolved", r->n_unsolved);
  json_out_int(o, "n_pivot", r->work.pivots);
  json_out_int(o, "n_iter", r->work.iterations);
  json_out_int(o, "n_factor", r->work.factorizations);
  json_out_int(o, "n_matvec", r->work.matvecs);
  json_out_int(o, "n_evaluations", r->n_evaluations);
  json_out_int(o, "n_mode_changes", r->n_modes);
  json_out_int(o, "n_fallback", r->n_fallbacks + r->work.fallbacks);
  json_out_int(o, "uniqueness", r->deficit_max);
  json_out_int(o, "n_shared", r->n_shared);
  json_out_int(o, "n_share_missed", r->n_share_missed);
}

/* null: not measured, no problem was posed or no step has impulses to judge. */
static void put_errors(json_t *o, const sim_result *r) {
  const bool solved = r->n_solves > 0, judged = r->n_judged > 0;
  json_out_bool(o, "verified", r->verified && r->status == RUN_OK);
  json_out_real(o, "rho_max", solved ? r->rho_max : HUGE_VAL);
  json_out_real(o, "res_natural_max", solved ? r->natural_max : HUGE_VAL);
  json_out_real(o, "res_ncp_max", judged ? r->ncp_max : HUGE_VAL);
  json_out_real(o, "res_ncp_rel_max", judged ? r->ncp_rel_max : HUGE_VAL);
  json_out_real(o, "res_cone_rel_max", judged ? r->cone_rel_max : HUGE_VAL);
  json_out_real(o, "dissipation_gap_max_J", judged ? r->dissipation_max : HUGE_VAL);
  json_out_real(o, "stiffness_ratio_min", r->stiffness_ratio); /* null: nothing regularised */
  json_out_real(o, "v_slip_max", r->v_slip);
  json_out_real(o, "deflection_max_m", r->deflection);
  json_out_real(o, "penetration_max_m", r->penetration_max);
  json_out_real(o, "approach_max_m", r->approach_max); /* null: not a formulation with steps */
  json_out_real(o, "energy_defect_J", r->energy_defect);
  json_out_real(o, "energy_drift_rel", r->energy_drift_rel);
}

static void put_times(json_t *o, const sim_result *r) {
  json_out_real(o, "t_contacts_s", r->time.contacts);
  json_out_real(o, "t_assemble_s", r->time.assemble);
  json_out_real(o, "t_setup_s", r->time.setup);
  json_out_real(o, "t_factor_s", r->time.factor);
  json_out_real(o, "t_solve_s", r->time.solve);
  json_out_real(o, "t_share_s", r->time.share);
  json_out_real(o, "t_advance_s", r->time.advance);
  json_out_real(o, "t_watch_s", r->time.watch);
  json_out_real(o, "t_total_s", sim_total_seconds(r));
}

static void put_combination(json_t *o, const formulation_choice *form,
                            const solver_choice *solver) {
  json_out_text(o, "formulation", form->form->name);
  json_out_text(o, "formulation_options", form->config);
  json_out_text(o, "solver", solver->solver->name);
  json_out_text(o, "solver_options", solver->config);
}

/* The steps of combination k, where the run came to it. */
static void put_part(json_t *o, const sim_result *r, int k) {
  if (k >= r->n_part) {
    return;
  }
  const sim_part *b = &r->part[k];
  const sim_part end = {.steps_before = r->steps,
                        .solves_before = r->n_solves,
                        .unsolved_before = r->n_unsolved,
                        .work_before = r->work,
                        .time_before = r->time};
  const sim_part *e = (k + 1 < r->n_part) ? &r->part[k + 1] : &end;
  json_out_int(o, "steps", e->steps_before - b->steps_before);
  json_out_text(o, "status", run_status_name(b->status));
  json_out_bool(o, "verified", b->verified && b->status == RUN_OK);
  json_out_real(o, "rho_max", e->solves_before > b->solves_before ? b->rho_max : HUGE_VAL);
  json_out_int(o, "n_solves", e->solves_before - b->solves_before);
  json_out_int(o, "n_unsolved", e->unsolved_before - b->unsolved_before);
  json_out_int(o, "n_pivot", e->work_before.pivots - b->work_before.pivots);
  json_out_int(o, "n_iter", e->work_before.iterations - b->work_before.iterations);
  json_out_int(o, "n_factor", e->work_before.factorizations - b->work_before.factorizations);
  json_out_real(o, "t_solve_s", e->time_before.solve - b->time_before.solve);
  json_out_real(o, "t_total_s", sim_times_sum(&e->time_before) - sim_times_sum(&b->time_before));
}

/* Those of a run that changes them, with the steps that are done before. */
static void put_changes(json_t *o, const combination_plan *p, const sim_result *r) {
  if (p->n == 0) {
    return;
  }
  json_t *all = json_array();
  for (int k = 0; k < p->n; k++) {
    json_t *one = json_object();
    json_out_int(one, "from", p->span[k].from);
    put_combination(one, &p->span[k].form, &p->span[k].solver);
    put_part(one, r, k);
    (void)json_array_append_new(all, one);
  }
  (void)json_object_set_new(o, "combinations", all);
}

static json_t *to_json(const simulation *s, const char *scene, const series *record,
                       const sim_result *r, bool *all_ok) {
  json_t *o = json_object();
  char hash[24];
  (void)snprintf(hash, sizeof hash, "%016llx", (unsigned long long)r->hash);
  const char *colon = strchr(scene, ':');
  json_out_text(o, "scene", s->spec.id);
  json_out_text(o, "parameters", colon != NULL ? colon + 1 : "");
  put_combination(o, s->request.form, s->request.solver);
  put_changes(o, &s->combinations, r);
  json_out_text(o, "variant", r->variant);
  json_out_int(o, "contact_order", (long long)s->request.contact_order); /* 0: given */
  json_out_real(o, "step_s", s->request.h);
  json_out_int(o, "steps", r->steps);
  json_out_real(o, "t_end_s", record->column[SERIES_TIME][record->n_row - 1]);
  json_out_text(o, "status", run_status_name(r->status));
  json_out_text(o, "claimed", run_status_name(r->claimed));
  json_out_text(o, "note", r->note);
  (void)json_object_set_new(o, "observables", observables(record));
  (void)json_object_set_new(o, "predictions", predictions(s, record, r, all_ok));
  (void)json_object_set_new(o, "trajectory_error", yardstick(s, record, r));
  put_counts(o, r);
  put_sleep(o, &s->request, r);
  put_islands(o, &s->request, r);
  put_memory(o, &s->request);
  put_errors(o, r);
  put_effects(o, "effects_declared", s->spec.effects);
  put_effects(o, "effects_simulated", s->request.effects);
  put_effects(o, "effects_seen", r->effects_seen);
  put_auto(o, s);
  put_error(o, s);
  json_out_text(o, "solution_hash", hash);
  put_times(o, r);
  return o;
}

/* ---- verb ------------------------------------------------------------------------------------ */

typedef struct simulate_files {
  const char *trajectory, *end, *trace, *dump_step, *dump_steps, *out, *steps;
} simulate_files;

typedef struct simulate_options {
  simulation_texts t;
  simulate_files f;
} simulate_options;

/* What is told of a run once all of its files are there. */
typedef struct simulate_report {
  json_t *object;
  int code;
} simulate_report;

static base_status simulate_and_judge(simulation *s, const char *scene, simulate_report *out,
                                      base_error *err) {
  series record;
  sim_result r;
  const base_status done = simulation_run(s, &record, &r, err);
  if (done == BASE_OK) {
    bool all_ok;
    out->object = to_json(s, scene, &record, &r, &all_ok);
    const bool promised = !(s->error.E > 0.0) || s->found.promised;
    out->code = (r.status == RUN_OK && r.verified && all_ok && promised) ? CLI_OK : CLI_HONEST;
  }
  series_close(&record);
  return done;
}

/* With the problems of chosen steps, where asked for. */
static base_status with_dump(simulation *s, const char *scene, const simulate_files *f,
                             simulate_report *report, base_error *err) {
  const char *range = (f->dump_steps != NULL) ? f->dump_steps : f->dump_step;
  if (range == NULL || f->out == NULL) {
    if (range != NULL || f->out != NULL) {
      return BASE_FAIL(err, BASE_EINVAL, "--dump-step N and --out DIR go together");
    }
    return simulate_and_judge(s, scene, report, err);
  }
  if (f->dump_step != NULL && (f->dump_steps != NULL || strchr(f->dump_step, ':') != NULL)) {
    return BASE_FAIL(err, BASE_EINVAL, "--dump-step %s: need one step, or --dump-steps A:B alone",
                     f->dump_step);
  }
  dump d;
  long first;
  long last;
  BASE_TRY(dump_range(range, &first, &last, err));
  BASE_TRY(dump_open(&d, f->out, first, last, err));
  s->request.dump = &d;
  const base_status done = simulate_and_judge(s, scene, report, err);
  s->request.dump = NULL;
  base_error why = {0};
  const base_status closed = dump_close(&d, done == BASE_OK, &why);
  if (done == BASE_OK && closed != BASE_OK) {
    *err = why;
    return closed;
  }
  return done;
}

static base_status with_trace(simulation *s, const char *scene, const simulate_files *f,
                              simulate_report *report, base_error *err) {
  if (f->trace == NULL) {
    return with_dump(s, scene, f, report, err);
  }
  if (s->request.islands) {
    return BASE_FAIL(err, BASE_EINVAL, "--trace %s: the history of one solve, need --islands off",
                     f->trace);
  }
  trace_file history;
  BASE_TRY(trace_open(&history, f->trace, err));
  s->request.trace = &history;
  const base_status done = with_dump(s, scene, f, report, err);
  s->request.trace = NULL;
  return trace_finish(&history, done, err);
}

/* With the scene that begins where the run ends. */
static base_status with_end(simulation *s, const char *scene, const simulate_files *f,
                            simulate_report *report, base_error *err) {
  if (f->end == NULL) {
    return with_trace(s, scene, f, report, err);
  }
  scene_spec end;
  base_out file;
  BASE_TRY(world_can_restart(&s->spec, err));
  BASE_TRY(base_out_open(&file, f->end, err));
  base_status done = spec_copy(&s->spec, &end, err);
  s->request.end = &end;
  if (done == BASE_OK) {
    done = with_trace(s, scene, f, report, err);
  }
  if (done == BASE_OK) {
    done = scene_write(file.to, &end, err);
  }
  s->request.end = NULL;
  spec_free(&end);
  return base_out_finish(&file, done, err);
}

/* With the files that the run is to leave behind. */
static base_status with_files(simulation *s, const char *scene, const simulate_files *f,
                              simulate_report *report, base_error *err) {
  if (f->trajectory == NULL) {
    return with_end(s, scene, f, report, err);
  }
  base_out file;
  BASE_TRY(base_out_open(&file, f->trajectory, err));
  s->request.trajectory = file.to;
  const base_status done = with_end(s, scene, f, report, err);
  s->request.trajectory = NULL;
  return base_out_finish(&file, done, err);
}

static const arg_option options[] = {
    ARG(simulate_options, t.formulation, "--formulation", ARG_TEXT, "FORMULATION",
        "formulation with its options behind a colon, or A/STEPS:B (B after so many steps); with "
        "--error it is chosen where it and --solver are missing"),
    ARG(simulate_options, t.solver, "--solver", ARG_TEXT, "SOLVER",
        "solver with its options behind a colon, or A/STEPS:B; what poses no problem does not "
        "ask it"),
    ARG(simulate_options, t.step, "--step", ARG_TEXT, "H", "step instead of the scene's",
        .unit = "s", .above = true),
    ARG(simulate_options, t.error, "--error", ARG_TEXT, "E",
        "error of the motion in place of a step: 1%, of the scene's scale, or 1e-3m, 0.01rad"),
    ARG(simulate_options, t.work, "--work", ARG_TEXT, "N",
        "most steps that the runs for --error may solve", .unit = "1", .above = true),
    ARG(simulate_options, t.time_limit, "--time-limit", ARG_TEXT, "T",
        "longest that the runs for --error may take: 30, 30s, 10m, 2h; none given: no limit"),
    ARG(simulate_options, t.steps, "--steps", ARG_TEXT, "FILE",
        "lengths of the steps, one a line [s]"),
    ARG(simulate_options, t.rows, "--rows", ARG_TEXT, "FILE|DIR",
        "measured errors (choices.tsv) that formulation and solver are chosen from"),
    ARG(simulate_options, f.steps, "--write-steps", ARG_OUTPUT, "FILE",
        "the steps of the run, those found by --error too, for --steps"),
    ARG(simulate_options, t.duration, "--duration", ARG_TEXT, "T",
        "duration instead of the scene's", .unit = "s", .above = true),
    ARG(simulate_options, t.tol, "--tol", ARG_TEXT, "T",
        "residual to stop at, the solver's option tol", .unit = "1"),
    ARG(simulate_options, t.effects, "--effects", ARG_TEXT, "SPEC",
        "effects to simulate: declared, all, -NAME,+NAME, +sleep (what lies still has no rows), "
        "SPEC/STEPS:SPEC (after so many steps), or auto:E"),
    ARG(simulate_options, t.start, "--start", ARG_TEXT, "cold|previous",
        "start of each solve: zero, or the answer of the step before"),
    ARG(simulate_options, t.contact_order, "--contact-order", ARG_TEXT, "given|random:N",
        "order of the contacts in the problem"),
    ARG(simulate_options, t.islands, "--islands", ARG_TEXT, "on|off",
        "solves what nothing couples part by part (off)"),
    ARG(simulate_options, t.threads, "--threads", ARG_TEXT, "N",
        "threads that share the work of a step; the answer is the same to the bit for any number "
        "(1)",
        .unit = "1", .min = 1, .max = BASE_THREADS_MAX),
    ARG(simulate_options, t.memory, "--memory", ARG_TEXT, "usual|least",
        "least: what one part of a step worked in goes back before the next begins, for up to a "
        "quarter more time (usual: from 32768 unknowns on)"),
    ARG(simulate_options, f.trajectory, "--trajectory", ARG_OUTPUT, "FILE.csv",
        "states of all bodies after each step"),
    ARG(simulate_options, f.end, "--write-end", ARG_OUTPUT, "FILE",
        "the scene that begins where the run ends, as a scene file"),
    ARG(simulate_options, f.trace, "--trace", ARG_OUTPUT, "FILE.csv", "history of every solve"),
    ARG(simulate_options, f.dump_step, "--dump-step", ARG_TEXT, "N",
        "writes the problems of step N as files; together with --out"),
    ARG(simulate_options, f.dump_steps, "--dump-steps", ARG_TEXT, "A:B",
        "writes the problems of steps A to B"),
    ARG(simulate_options, f.out, "--out", ARG_TEXT, "DIR", "folder of the dumped problems"),
};
static const arg_table args = {
    options, BASE_COUNT(options),
    1,       1,
    "SCENE", "scene with its parameters, or scene file; - is standard input"};

/* What is not defined never ran: its reason is a message, too. */
static void tell_unsupported(const json_t *o) {
  const char *status = json_string_value(json_object_get(o, "status"));
  const char *note = json_string_value(json_object_get(o, "note"));
  base_error err = {0};
  if (status != NULL && note != NULL && strcmp(status, run_status_name(RUN_UNSUPPORTED)) == 0) {
    (void)BASE_FAIL(&err, BASE_EUNSUPPORTED, "%s", note);
    (void)cli_report(&err);
  }
}

static int run(int argc, char **argv) {
  simulate_options o = {0};
  int n_positional;
  base_error err = {0};
  if (args_parse(&args, &o, argc, argv, &o.t.scene, &n_positional, &err) != BASE_OK) {
    return cli_report(&err);
  }
  if (o.t.error == NULL || o.t.error[0] == '\0') {
    o.t.work = args_typed("--work", o.t.work);
    o.t.time_limit = args_typed("--time-limit", o.t.time_limit);
  }
  simulation s;
  simulate_report report = {0};
  base_status done = simulation_open(&o.t, &s, &err);
  if (done == BASE_OK) {
    stop_catch_first_signal(); /* the run as far as it came is told; to an error, the finest that came to its end */
    s.request.until = (s.error.E > 0.0) ? s.request.until : HUGE_VAL;
  }
  if (done == BASE_OK && s.request.least_memory) {
    memory_return_from(1u << 16);
  }
  if (done == BASE_OK) {
    done = with_files(&s, o.t.scene, &o.f, &report, &err);
  }
  if (done == BASE_OK && o.f.steps != NULL) {
    /* all of a run that failed, so that the list fails too; up to a signal those that were taken */
    const long taken = (long)json_integer_value(json_object_get(report.object, "steps"));
    done = simulation_list_steps(&s, stop_requested() != 0 ? taken : sim_steps_planned(&s.request),
                                 &err);
  }
  if (done == BASE_OK) {
    put_choice(report.object, &s, &o.t, o.f.steps);
  }
  if (done == BASE_OK && o.f.steps != NULL) {
    done = step_list_write(&s.steps, o.f.steps, &err);
  }
  simulation_close(&s);
  if (done != BASE_OK) {
    json_decref(report.object);
    return cli_report(&err);
  }
  FILE *to = args_take_stdout(&args, &o) ? stderr : stdout;
  if (to == stdout) {
    tell_unsupported(report.object);
  }
  report.code = (stop_requested() != 0 && report.code != CLI_OK) ? cli_stopped() : report.code;
  return json_out_print(report.object, to) ? report.code : CLI_INTERNAL;
}

extern const cli_verb verb_simulate;
const cli_verb verb_simulate = {
    .name = "simulate",
    .args = &args,
    .help = "runs one scene and prints one JSON object with its predictions judged",
    .run = run,
};
