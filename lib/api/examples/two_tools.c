/* Presses a tissue with two tools, each alone and both at once: two_tools MODEL.h5 X Y Z X Y Z DX DY DZ
 * The tools move from outside to the contacts X Y Z [m] of the first and of the second, and on by the tool displacement
 * DX DY DZ [m]. Prints the force on each hand [N], alone and together. A tool that presses lowers the tissue around it,
 * so the other one meets less of it.
 * Build: cc -std=c99 two_tools.c $(pkg-config --cflags --libs tissue-c) -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <tissue.h>

static int fail(const char *why) {
    fprintf(stderr, "two_tools: %s\n", why);
    return EXIT_FAILURE;
}

/* Half a second in, half a second of rest, of the tools that press; the other one stays outside. force_N: of both.
 * Returns the first status that is not TISSUE_OK, else that. */
static tissue_status press(tissue_session *tissue, const double contact_m[6], const double push_m[3], const int presses[2], double force_N[6]) {
    int tick, k;
    for (tick = 0; tick < 1000; ++tick) {
        double position_m[6];
        const double part = tick < 500 ? tick / 500.0 : 1;
        tissue_status status;
        for (k = 0; k < 6; ++k) position_m[k] = contact_m[k] + (presses[k / 3] ? -0.5 + 1.5 * part : -0.5) * push_m[k % 3];
        status = tissue_tick_tools(tissue, 2, position_m, NULL, 0, force_N, NULL);
        if (status != TISSUE_OK) return status;
    }
    return TISSUE_OK;
}

static double length(const double *f) { return sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]); }

int main(int count, char **argument) {
    const char *const options[] = {"tools", "2", NULL};
    const int alone[2][2] = {{1, 0}, {0, 1}}, both[2] = {1, 1};
    double number[9], apart[2], force_N[6];
    tissue_model *model = NULL;
    tissue_session *tissue = NULL;
    int k;
    char rest;
    for (k = 0; k < 9 && count == 11; ++k)
        if (sscanf(argument[k + 2], "%lf%c", &number[k], &rest) != 1) count = 0;
    if (count != 11) {
        fprintf(stderr, "usage: two_tools MODEL.h5 X Y Z X Y Z DX DY DZ\n");
        return 2;
    }
    /* one model, a session at rest for each measurement */
    if (tissue_open_model(argument[1], options, &model) != TISSUE_OK) return fail(tissue_error());
    for (k = 0; k < 3; ++k) {
        const int *presses = k < 2 ? alone[k] : both;
        tissue_status status;
        if (tissue_begin(model, &tissue) != TISSUE_OK) return fail(tissue_error());
        status = press(tissue, number, number + 6, presses, force_N);
        if (status != TISSUE_OK) return fail(tissue_status_text(status));
        if (k < 2) apart[k] = length(force_N + 3 * k);
        tissue_close(&tissue);
    }
    for (k = 0; k < 2; ++k) printf("tool %d: %.4f N alone, %.4f N with the other\n", k + 1, apart[k], length(force_N + 3 * k));
    tissue_close_model(&model);
    return EXIT_SUCCESS;
}
