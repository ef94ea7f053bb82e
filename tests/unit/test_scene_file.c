/* Scene files of users: JSON and YAML say the same, and what is wrong is named in one line. */
#include "tests/support/check.h"

#include "problems/read/case_file.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *write_file(const char *ending, const char *text) {
  static char path[256];
  (void)snprintf(path, sizeof path, "%s/lcpbench_scene_%d.%s",
                 getenv("TMPDIR") != NULL ? getenv("TMPDIR") : "/tmp", (int)getpid(), ending);
  FILE *f = fopen(path, "wb");
  assert_non_null(f);
  assert_int_equal(fwrite(text, 1, strlen(text), f), strlen(text));
  assert_int_equal(fclose(f), 0);
  return path;
}

static const char json[] =
    "{\"id\": \"ramp\", \"dim\": 2, \"T\": 0.5, \"gravity\": [0, -9.81],"
    " \"bodies\": [{\"name\": \"b\", \"shape\": {\"type\": \"box\", \"half\": [0.2, 0.1]},"
    "   \"mass\": 2, \"pos\": [0, 0.1], \"vel\": [1.5, 0]},"
    "   {\"name\": \"c\", \"shape\": {\"type\": \"compound\", \"parts\": ["
    "     {\"shape\": {\"type\": \"disc\", \"r\": 0.1}, \"pos\": [0.2, 0]},"
    "     {\"shape\": {\"type\": \"capsule\", \"half_length\": 0.2, \"r\": 0.05}, \"angle\": 1}]},"
    "   \"mass\": 1, \"inertia\": 0.02, \"pos\": [0, 2]}],"
    " \"static\": [{\"name\": \"floor\", \"normal\": [0, 1], \"offset\": 0}],"
    " \"friction\": {\"default\": 0.4, \"pairs\": [[\"b\", \"floor\", 0.6]]},"
    " \"loads\": [{\"body\": \"b\", \"other\": \"c\", \"type\": \"spring\", \"k\": 10, \"c\": 1}],"
    " \"joints\": [{\"name\": \"j\", \"type\": \"ball\", \"body\": \"c\", \"anchor\": [0, 2.5]}],"
    " \"checks\": [{\"type\": \"state\", \"var\": \"b.x\", \"t\": 0.5, \"value\": 0.1,"
    "   \"tol\": {\"abs\": 1}}]}";

static const char yaml[] =
    "id: ramp\n"
    "dim: 2\n"
    "T: 0.5\n"
    "gravity: [0, -9.81]\n"
    "bodies:\n"
    "  - {name: b, shape: {type: box, half: [0.2, 0.1]}, mass: 2,\n"
    "     pos: [0, 0.1], vel: [1.5, 0]}\n"
    "  - name: c\n"
    "    shape:\n"
    "      type: compound\n"
    "      parts:\n"
    "        - {shape: {type: disc, r: 0.1}, pos: [0.2, 0]}\n"
    "        - {shape: {type: capsule, half_length: 0.2, r: 0.05}, angle: 1}\n"
    "    mass: 1\n"
    "    inertia: 0.02\n"
    "    pos: [0, 2]\n"
    "static:\n"
    "  - {name: floor, normal: [0, 1], offset: 0}\n"
    "friction: {default: 0.4, pairs: [[b, floor, 0.6]]}\n"
    "loads:\n"
    "  - {body: b, other: c, type: spring, k: 10, c: 1}\n"
    "joints:\n"
    "  - {name: j, type: ball, body: c, anchor: [0, 2.5]}\n"
    "checks:\n"
    "  - {type: state, var: b.x, t: 0.5, value: 0.1, tol: {abs: 1}}\n";

static void check_ramp(const scene_spec *s) {
  assert_int_equal(s->n_body, 2);
  check_close(s->body[0].inertia[0], 2.0 * (0.04 + 0.01) / 3.0, 1e-15);
  check_close(s->body[0].vel[0], 1.5, 0.0);
  assert_int_equal(s->body[1].shape.n_part, 2);
  check_close(s->body[1].shape.part[1].quat[3], sin(0.5), 1e-15);
  check_close(s->friction.pair[0].value, 0.6, 0.0);
  assert_int_equal(s->load[0].other, 1);
  assert_int_equal(s->joint[0].other, -1);
  assert_int_equal(s->effects, EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION |
                                   EFFECT_LOADS | EFFECT_DAMPING | EFFECT_JOINTS);
}

static void json_and_yaml_agree(void **state) {
  (void)state;
  base_error err = {0};
  scene_spec a, b, c;
  check_ok(scene_load(write_file("json", json), &a, &err), &err);
  check_ok(scene_load(write_file("yaml", yaml), &b, &err), &err);
  check_ramp(&a);
  check_ramp(&b);
  check_ok(spec_copy(&a, &c, &err), &err);
  spec_free(&a);
  check_ramp(&c); /* owns everything */
  spec_free(&b);
  spec_free(&c);
}

#define HEAD "{\"id\": \"s\", \"dim\": 2, \"T\": 1, "
#define BALL                                                                                       \
  "{\"name\": \"a\", \"shape\": {\"type\": \"disc\", \"r\": 1}, \"mass\": 1, \"pos\": [0, 0]}"
#define BODIES "\"bodies\": [" BALL "]"

#define A_X               "\"var\": \"a.x\", "
#define CHECK(type, more) HEAD BODIES ", \"checks\": [{\"type\": \"" type "\", " more "}]}"
#define LOAD(type, more)  HEAD BODIES ", \"loads\": [{\"type\": \"" type "\", " more "}]}"
#define JOINT(type, more)                                                                          \
  HEAD BODIES ", \"joints\": [{\"type\": \"" type "\", \"body\": \"a\", \"anchor\": [0, 0], " more \
              "}]}"

#define HEAD3 "{\"id\": \"s\", \"dim\": 3, \"T\": 1, "
#define POLYGON(dim, pos, more, vertices)                                                          \
  "{\"id\": \"s\", \"dim\": " dim                                                                  \
  ", \"T\": 1, \"bodies\": [{\"name\": \"a\", \"mass\": 1, \"pos\": " pos more                     \
  ", \"shape\": {\"type\": \"polygon\", \"vertices\": [" vertices "]}}]}"
#define INERTIA ", \"inertia\": 1"

static const struct {
  const char *text, *says;
} bad[] = {
    {"", "JSON"},
    {"{\"id\": \"s\"", "JSON"},
    {"[1, 2]", "need an object"},
    {"{\"id\": \"s\", \"id\": \"t\"}", "duplicate"},
    {"{\"dim\": 2}", "no scene"},
    {HEAD "\"bodies\": []}", "is empty"},
    {HEAD "\"colour\": 1, " BODIES "}", "unknown key 'colour'"},
    {"{\"id\": \"s\", \"dim\": 4, \"T\": 1, " BODIES "}", "dim = 4"},
    {"{\"id\": \"s\", \"dim\": 2, " BODIES "}", "needs 'T'"},
    {"{\"id\": \"s\", \"dim\": 2, \"T\": -1, " BODIES "}", "T = -1"},
    {HEAD "\"bodies\": [{\"name\": \"a\", \"shape\": {\"type\": \"disc\", \"r\": 1}, \"mass\": -2,"
          " \"pos\": [0, 0]}]}",
     "mass = -2"},
    {HEAD "\"bodies\": [{\"name\": \"a\", \"shape\": {\"type\": \"torus\", \"r\": 1}, \"mass\": 2,"
          " \"pos\": [0, 0]}]}",
     "type 'torus'"},
    {HEAD "\"bodies\": [{\"name\": \"a\", \"shape\": {\"type\": \"disc\", \"r\": 0}, \"mass\": 2,"
          " \"pos\": [0, 0]}]}",
     "r = 0"},
    {HEAD "\"bodies\": [{\"name\": \"a\", \"shape\": {\"type\": \"disc\", \"r\": 1e999},"
          " \"mass\": 2, \"pos\": [0, 0]}]}",
     "JSON"},
    {HEAD "\"bodies\": [" BALL ", " BALL "]}", "'a' is used twice"},
    {HEAD "\"bodies\": [{\"name\": \"*\", \"shape\": {\"type\": \"disc\", \"r\": 1},"
          " \"mass\": 2, \"pos\": [0, 0]}]}",
     "that is not '*'"},
    {HEAD BODIES ", \"loads\": [{\"body\": \"z\", \"type\": \"constant_force\"}]}",
     "no body named 'z'"},
    {HEAD BODIES ", \"friction\": {\"pairs\": [[\"a\", \"q\", 1]]}}", "'q'"},
    {HEAD BODIES ", \"friction\": {\"default\": -0.1}}", "friction default = -0.1"},
    {HEAD BODIES ", \"restitution\": {\"default\": 1.5}}", "restitution default = 1.5"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"state\", \"var\": \"z.x\", \"value\": 1}]}", "'z.x'"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"state\", \"var\": \"a.z\", \"value\": 1}]}",
     "quantity 'z'"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"stat\"}]}", "check type 'stat'"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"state\", \"var\": \"a.x\", \"value\": 1, \"t\": 2}]}",
     "after the end"},
    {HEAD BODIES ", \"needs\": [\"magnetism\"]}", "no such effect"},
    {HEAD BODIES ", \"needs\": [\"contact\"]}", "declares contact"},
    {HEAD BODIES ", \"static\": [{\"name\": \"f\", \"normal\": [0, 2]}]}", "length 2"},
    {HEAD BODIES ", \"gravity\": [0, 0, 1]}", "need 2 numbers"},
    {HEAD BODIES ", \"hs\": [0]}", "h = 0"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"state\", \"var\": \"a.x\"}]}", "needs 'value'"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"state\", \"var\": \"a.x\", \"value\": \"0.5\"}]}",
     "value: need a number"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"event_time\", \"event\": \"stop\", \"value\": 1}]}",
     "event_time needs a var"},
    {HEAD BODIES ", \"checks\": [{\"type\": \"event_time\", \"var\": \"a.x\", \"value\": 1}]}",
     "between bodies"},
    {HEAD BODIES ", \"if_off\": {\"gravity\": {\"var\": \"a.x\"}}}", "needs 'value'"},
    {HEAD BODIES ", \"contact_multiplicity\": 257}", "need 1 to 256"},
    {HEAD BODIES ", \"scenes\": []}", "unknown key 'scenes'"},
    {HEAD
     "\"bodies\": [{\"name\": \"a\", \"pos\": [0, 0], \"shape\": {\"type\": \"disc\", \"r\": 1},"
     " \"kinematic\": {}, \"prescribed\": {\"x\": {\"v0\": 1}}}]}",
     "both kinematic and prescribed"},
    {HEAD
     "\"bodies\": [{\"name\": \"a\", \"pos\": [0, 0], \"shape\": {\"type\": \"disc\", \"r\": 1},"
     " \"kinematic\": {\"vel\": [1, 0]}, \"lock\": [\"x\"]}]}",
     "no dofs to lock"},
    {HEAD3 "\"bodies\": [{\"name\": \"a\", \"pos\": [0, 0, 0], \"mass\": 1, \"inertia\": [1, 1, "
           "1], \"shape\":"
           " {\"type\": \"compound\", \"parts\": [{\"shape\": {\"type\": \"point\"}, \"quat\": [0, "
           "0, 0, 0]}]}}]}",
     "quat of length 1"},
    {POLYGON("2", "[0, 0]", "", "[0,0],[3,0],[0,3]"), "homogeneous polygon is at (1, 1)"},
    {POLYGON("2", "[0, 0]", INERTIA, "[0,0],[0,1],[1,0]"), "counter-clockwise"},
    {POLYGON("2", "[0, 0]", INERTIA, "[0,1],[-0.6,-0.8],[0.95,0.3],[-0.95,0.3],[0.6,-0.8]"),
     "once round"},
    {POLYGON("2", "[0, 0]", INERTIA, "[0,0],[1,0],[0,1],[0,0],[1,0],[0,1]"), "once round"},
    {POLYGON("2", "[0, 0]", INERTIA, "[0,0],[1,0],[1,0],[0,1]"), "repeated"},
    {POLYGON("2", "[0, 0]", INERTIA, "[0,0],[1,0],[2,0]"), "convex"},
    {POLYGON("3", "[0, 0, 0]", "", "[0,0],[1,0],[0,1]"), "a polygon is for dim 2, the scene has 3"},
    {"{\"id\": \"s\", \"dim\": 3, \"T\": 1, \"bodies\": [{\"name\": \"a\", \"mass\": 1, \"pos\": "
     "[0, 0, 0],"
     " \"shape\": {\"type\": \"sphere\", \"r\": 1}, \"prescribed\": {\"rx\": {\"v0\": 1, \"a\": "
     "0}, \"ry\":"
     " {\"v0\": 0, \"a\": 1}}}]}",
     "axis that stands still"},
    /* what would be passed over in silence */
    {CHECK("max_speed", "\"value\": 3"), "'value' says nothing in a max_speed check: its tol is"},
    {CHECK("max_drift", A_X "\"value\": 3"), "'value' says nothing in a max_drift check"},
    {CHECK("max_speed", "\"var\": \"a.vx\""), "'var' says nothing"},
    {CHECK("max_penetration", "\"rel\": 0.1"), "'rel' says nothing"},
    {CHECK("finite", "\"tol\": {\"abs\": 1}"), "'tol' says nothing"},
    {CHECK("min_change", A_X "\"value\": 1, \"tol\": {\"h\": 1}"), "'tol' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"event\": \"stop\""), "'event' says nothing in a state"},
    {CHECK("state", A_X "\"value\": 1, \"n\": 3"), "'n' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"dvalue_dh\": 3"), "'dvalue_dh' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"t0\": 0.1"), "'t0' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"t1\": 0.1"), "'t1' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"component\": \"normal\""), "'component' says nothing"},
    {CHECK("state", A_X "\"value\": 1, \"pair\": [\"a\", \"*\"]"), "'pair' says nothing"},
    {CHECK("state", "\"var\": \"a.vel\", \"value\": 1, \"dir\": [0, 0]"), "dir has length 0"},
    {HEAD BODIES
     ", \"if_off\": {\"gravity\": {\"var\": \"a.vel\", \"value\": 1, \"dir\": [0, 0]}}}",
     "dir has length 0"},
    {CHECK("contact_force", "\"pair\": [\"a\", \"a\"], \"value\": 1"), "two different names"},
    {HEAD BODIES ", \"friction\": {\"pairs\": [[\"a\", \"a\", 1]]}}", "two different names"},
    {HEAD BODIES ", \"no_collision\": [[\"a\", \"a\"]]}", "two different names"},
    {LOAD("constant_force", "\"body\": \"a\""), "needs 'force' or 'torque'"},
    {LOAD("force_ramp", "\"body\": \"a\", \"dir\": [1, 0]"), "needs 'rate'"},
    {LOAD("force_sine", "\"body\": \"a\", \"dir\": [1, 0]"), "needs 'amplitude'"},
    {LOAD("torsion_spring", "\"body\": \"a\", \"rest\": 1"), "needs 'k' or 'c'"},
    {LOAD("spring_to_moving_anchor", "\"body\": \"a\", \"dir\": [1, 0]"), "needs 'k' or 'c'"},
    {JOINT("fixed", "\"other_anchor\": [1, 0]"), "'other_anchor' is for a distance alone"},
    {HEAD "\"bodies\": [{\"name\": \"a\", \"shape\": {\"type\": \"point\"}, \"pos\": [0, 0], "
          "\"vel\": [1, 0], \"kinematic\": {}}]}",
     "'vel' beside kinematic"},
};

static void refused(const char *ending, const char *text, const char *says) {
  base_error err = {0};
  scene_spec s;
  if (scene_load(write_file(ending, text), &s, &err) == BASE_OK) {
    spec_free(&s);
    fail_msg("accepted: %s", text);
  }
  if (strstr(err.text, says) == NULL || strchr(err.text, '\n') != NULL) {
    fail_msg("'%s' should say '%s': %s", err.text, says, text);
  }
}

static void bad_scenes_are_named(void **state) {
  (void)state;
  for (int i = 0; i < BASE_COUNT(bad); i++) {
    refused("json", bad[i].text, bad[i].says);
  }
}

static void bad_yaml_is_named(void **state) {
  (void)state;
  refused("yaml", "", "empty");
  refused("yaml", "id: s\nid: t\n", "twice");
  refused("yaml", "a: &x [1]\nid: *x\n", "aliases");
  refused("yaml", "id: [1, 2\n", "line");
  refused("yaml", "--- {id: s}\n--- {id: t}\n", "one document");
  refused("yaml", "? [a]\n: 1\n", "key");
  char deep[1200] = "id: ";
  memset(deep + 4, '[', 1000);
  refused("yaml", deep, "line");
  refused("yaml", "id: s\ndim: 2\nT: .nan\nbodies: []\n", "need a number");
  refused("yaml", "id: \"\\xff\"\ndim: x\n", "");
  refused("yaml", "- 1\n- 2\n", "need an object");
}

/* Every prefix of a good file is either refused or (rarely) still a whole scene. */
static void truncation_never_crashes(void **state) {
  (void)state;
  char cut[sizeof json];
  for (size_t n = 0; n + 1 < sizeof json; n += 3) {
    base_error err = {0};
    scene_spec s;
    memcpy(cut, json, n);
    cut[n] = '\0';
    assert_int_not_equal(scene_load(write_file("json", cut), &s, &err), BASE_OK);
  }
  char cut_yaml[sizeof yaml];
  for (size_t n = 0; n < sizeof yaml; n += 5) {
    base_error err = {0};
    scene_spec s;
    memcpy(cut_yaml, yaml, n);
    cut_yaml[n] = '\0';
    if (scene_load(write_file("yaml", cut_yaml), &s, &err) == BASE_OK) {
      spec_free(&s);
    }
  }
}

static void missing_and_ambiguous_files(void **state) {
  (void)state;
  base_error err = {0};
  scene_spec s;
  assert_int_equal(scene_load("/nonexistent/x.json", &s, &err), BASE_EIO);
  assert_int_equal(scene_load("/tmp/", &s, &err), BASE_EINVAL);
  assert_int_equal(scene_load("no_such_scene", &s, &err), BASE_EINVAL);
  assert_int_equal(scene_load("incline:mu=-1", &s, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "mu=-1"));
  assert_int_equal(scene_load("incline:colour=1", &s, &err), BASE_EINVAL);
  assert_non_null(strstr(err.text, "colour"));
  char two[2 * sizeof json + 8], with_id[512];
  (void)snprintf(two, sizeof two, "[%s, %s]", json, json);
  memcpy(strstr(two + sizeof json, "ramp"), "pipe", 4);
  const char *path = write_file("json", two);
  refused("json", two, "holds 2 scenes");
  (void)snprintf(with_id, sizeof with_id, "%s#pipe", path);
  check_ok(scene_load(with_id, &s, &err), &err);
  assert_string_equal(s.id, "pipe");
  spec_free(&s);
}

static void declared(const char *needs, unsigned effects) {
  static const char rest[] = "\"gravity\": [0, -9.81], \"friction\": {\"default\": 0.5}, " BODIES
                             ", \"static\": [{\"name\": \"f\", \"normal\": [0, 1]}]";
  char text[1024];
  base_error err = {0};
  scene_spec s;
  (void)snprintf(text, sizeof text, HEAD "%s%s}", needs, rest);
  check_ok(scene_load(write_file("json", text), &s, &err), &err);
  assert_int_equal(s.effects, effects);
  check_ok(spec_settle_effects(&s, &err), &err); /* settled is settled */
  assert_int_equal(s.effects, effects);
  spec_free(&s);
}

/* An empty list of needs declares nothing but what the data bring with them; only without one all that occurs is simulated. */
static void an_empty_list_declares_nothing(void **state) {
  (void)state;
  const unsigned all = EFFECT_GRAVITY | EFFECT_CONTACT | EFFECT_FRICTION | EFFECT_ROTATION;
  declared("", all);
  declared("\"needs\": [], ", EFFECT_GRAVITY);
  declared("\"needs\": [\"third_dimension\"], ", EFFECT_GRAVITY);
  declared("\"needs\": [], \"observe\": [\"a.omega\"], ", EFFECT_GRAVITY | EFFECT_ROTATION);
  declared("\"needs\": [\"contact\"], ", EFFECT_GRAVITY | EFFECT_CONTACT);
}

static int clean_up(void **state) {
  (void)state;
  (void)remove(write_file("json", ""));
  (void)remove(write_file("yaml", ""));
  return 0;
}

/* A planar capsule without inertia is the homogeneous one: strips across it add up to the same. */
static void planar_capsules_are_solid(void **state) {
  (void)state;
  const double a = 0.4, r = 0.3;
  double inertia[3] = {0}, area = 0.0, moment = 0.0;
  base_error err = {0};
  const spec_shape capsule = {.kind = SPEC_ROD, .r = r, .half = {a}},
                   rod = {.kind = SPEC_ROD, .half = {a}};
  check_ok(spec_solid_inertia(&capsule, 2, 2.0, inertia, &err), &err);
  const int n = 20000;
  for (int k = 0; k < n; k++) {
    const double x = (a + r) * (k + 0.5) / n, d = fmax(x - a, 0.0), half = sqrt(r * r - d * d);
    area += half;
    moment += half * x * x + half * half * half / 3.0;
  }
  check_close(inertia[0], 2.0 * moment / area, 1e-6);
  check_ok(spec_solid_inertia(&rod, 2, 2.0, inertia, &err), &err);
  check_close(inertia[0], 2.0 * a * a / 3.0, 1e-15);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(json_and_yaml_agree),
      cmocka_unit_test(planar_capsules_are_solid),
      cmocka_unit_test(bad_scenes_are_named),
      cmocka_unit_test(bad_yaml_is_named),
      cmocka_unit_test(truncation_never_crashes),
      cmocka_unit_test(missing_and_ambiguous_files),
      cmocka_unit_test(an_empty_list_declares_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, clean_up);
}
