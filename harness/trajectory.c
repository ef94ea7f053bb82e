#include "harness/trajectory.h"

#include "lcp/base/fields.h"

static base_status written(FILE *to, base_error *err) {
  return ferror(to) ? BASE_FAIL(err, BASE_EIO, "trajectory: could not be written") : BASE_OK;
}

base_status trajectory_header(FILE *to, base_error *err) {
  if (to == NULL) {
    return BASE_OK;
  }
  (void)fputs("t_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,"
              "omega_x_rad_s,omega_y_rad_s,omega_z_rad_s\n",
              to);
  return written(to, err);
}

static void put(FILE *to, const double *x, int n) {
  for (int i = 0; i < n; i++) {
    char number[32];
    base_real_print(x[i], number, sizeof number);
    (void)fprintf(to, ",%s", number);
  }
}

base_status trajectory_row(FILE *to, const scene_spec *spec, const world *w, base_error *err) {
  if (to == NULL) {
    return BASE_OK;
  }
  for (int b = 0; b < world_n_body(w); b++) {
    double pos[3];
    double quat[4];
    double vel[3];
    double omega[3];
    char time[32];
    world_body_pose(w, b, pos, quat);
    world_body_velocity(w, b, vel, omega);
    base_real_print(world_time(w), time, sizeof time);
    (void)fprintf(to, "%s,%s", time, b < spec->n_body ? spec->body[b].name : "");
    put(to, pos, 3);
    put(to, quat, 4);
    put(to, vel, 3);
    put(to, omega, 3);
    (void)fputc('\n', to);
  }
  return written(to, err);
}
