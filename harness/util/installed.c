#include "harness/util/installed.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

bool installed_data(const char *name, char *path, size_t cap) {
  char program[4096];
  const ssize_t length = readlink("/proc/self/exe", program, sizeof program);
  if (length <= 0 || (size_t)length >= sizeof program) {
    return false;
  }
  program[length] = '\0';
  *strrchr(program, '/') = '\0';
  const char *data = LCPBENCH_DATA;
  const int written = (data[0] == '/') ? snprintf(path, cap, "%s/%s", data, name)
                                       : snprintf(path, cap, "%s/%s/%s", program, data, name);
  return written > 0 && (size_t)written < cap && access(path, R_OK) == 0;
}
