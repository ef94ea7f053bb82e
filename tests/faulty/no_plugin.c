/* A shared object that is no plug-in. */
extern int no_plugin;
int no_plugin = 1;
