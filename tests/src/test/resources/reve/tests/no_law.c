/* A shared library, but no law library. */
int answer(void) { return 42; }
