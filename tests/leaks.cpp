/// Suppresses leak reports of libhdf5 only. It does not free all memory of a damaged file that it refuses, and tests
/// and fuzzing open thousands of these.
extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libhdf5\n";
}
