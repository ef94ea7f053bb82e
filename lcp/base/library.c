#include "lcp/base/library.h"

#include <dlfcn.h>
#include <string.h>

base_status base_library_open(const char *file, const char *purpose, const char *const *name,
                              int count, void *table, base_error *err) {
  void *library = dlopen(file, RTLD_NOW | RTLD_LOCAL);
  if (library == NULL) {
    return BASE_FAIL(err, BASE_EEXTERNAL, "%s needs %s, which cannot be loaded: %s", purpose, file,
                     dlerror());
  }
  void *program = dlopen(NULL, RTLD_NOW);
  for (int i = 0; i < count; i++) {
    /* a program that is itself linked with the library may hold the one copy of a variable that the library writes to */
    void *symbol = (program != NULL) ? dlsym(program, name[i]) : NULL;
    symbol = (symbol != NULL) ? symbol : dlsym(library, name[i]);
    if (symbol == NULL) {
      return BASE_FAIL(err, BASE_EEXTERNAL, "%s needs %s of %s: it has none", purpose, name[i],
                       file);
    }
    memcpy((unsigned char *)table + (size_t)i * sizeof symbol, &symbol, sizeof symbol);
  }
  return BASE_OK;
}
