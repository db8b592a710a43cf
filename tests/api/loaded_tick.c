/* loaded_tick LIBRARY MODEL: opens the library with dlopen, as a plugin of an engine does, and ticks in a separate
 * thread, with valid positions and one that is refused. Prints the number of allocations in that thread. Exit status 0 if
 * no tick allocated, if statuses and force are correct, and if the allocations for the thread's error text were
 * counted. */
#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>

#include "tissue.h"

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);

/* A variable of the program, whose storage exists before the thread. For thread-local variables of a library the loader
 * would call malloc. */
static __thread long allocations = 0;
void* malloc(size_t size) { return ++allocations, __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return ++allocations, __libc_calloc(count, size); }
void* realloc(void* memory, size_t size) { return ++allocations, __libc_realloc(memory, size); }

struct functions {
    tissue_status (*open)(const char*, const char* const*, tissue_session**);
    tissue_status (*tick)(tissue_session*, const double*, double, double*);
    const char* (*error)(void);
};

struct work {
    struct functions library;
    tissue_session* session;
    tissue_status first, last;
    double largest_N;
    long in_ticks, in_error;
};

static void* play(void* given) {
    struct work* w = given;
    double at[3] = {0.05, NAN, 0.3}, force[3];
    long before = allocations;
    w->first = w->library.tick(w->session, at, 0, force);
    for (int k = 0; k < 300; ++k) {
        at[1] = 0.101 - 0.003 * sin(9e-3 * k);
        w->last = w->library.tick(w->session, at, 0, force);
        w->largest_N = fmax(w->largest_N, hypot(force[0], force[1]));
    }
    w->in_ticks = allocations - before;
    /* the error text of a thread is allocated at its first call, and this allocation is counted */
    before = allocations;
    w->library.error();
    w->in_error = allocations - before;
    return NULL;
}

int main(int count, char** argument) {
    void* library = count == 3 ? dlopen(argument[1], RTLD_NOW | RTLD_LOCAL) : NULL;
    if (!library) return fprintf(stderr, "loaded_tick: %s\n", count == 3 ? dlerror() : "usage: loaded_tick LIBRARY MODEL"), 2;
    struct work w = {0};
    *(void**)&w.library.open = dlsym(library, "tissue_open");
    *(void**)&w.library.tick = dlsym(library, "tissue_tick");
    *(void**)&w.library.error = dlsym(library, "tissue_error");
    const char* const none[] = {NULL};
    pthread_t thread;
    if (w.library.open(argument[2], none, &w.session) != TISSUE_OK) return fprintf(stderr, "loaded_tick: %s\n", w.library.error()), 2;
    if (pthread_create(&thread, NULL, play, &w) != 0 || pthread_join(thread, NULL) != 0) return 2;
    printf("refused %d, last %d, at most %g N: %ld allocations in ticks, %ld as the thread asks for its error\n", w.first == TISSUE_FAULT, w.last, w.largest_N, w.in_ticks, w.in_error);
    return !(w.first == TISSUE_FAULT && w.last == TISSUE_OK && w.largest_N > 0.01 && w.in_ticks == 0 && w.in_error > 0);
}
