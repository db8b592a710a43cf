/// libhdf5 does not give back all that it holds of a damaged file it refuses, and tests and fuzzing open thousands of those; what we leak is reported.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libhdf5\n";
}
