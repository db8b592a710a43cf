/* Indents a tissue along a file of device positions: press MODEL.h5 [NAME VALUE]... < POSITIONS
 * Each line of standard input is a device position x y z [m] of one tick. Each line of standard output is the force on
 * the hand [N], in hexadecimal, so that no bit is lost.
 * Build: cc press.c $(pkg-config --cflags --libs tissue-c) */
#include <stdio.h>
#include <stdlib.h>
#include <tissue.h>

static int fail(void) {
    fprintf(stderr, "press: %s\n", tissue_error());
    return EXIT_FAILURE;
}

int main(int count, char **argument) {
    if (count < 2) {
        fprintf(stderr, "usage: press MODEL.h5 [NAME VALUE]... < POSITIONS\n");
        return 2;
    }
    tissue_session *tissue = NULL;
    /* argument[] ends with NULL, as the list of options must */
    if (tissue_open(argument[1], (const char *const *)argument + 2, &tissue) != TISSUE_OK) return fail();

    double position[3], force[3];
    while (scanf("%lf %lf %lf", &position[0], &position[1], &position[2]) == 3) {
        /* continue after a refused position: its force is zero */
        const tissue_status status = tissue_tick(tissue, position, 0, force);
        if (status != TISSUE_OK) fprintf(stderr, "press: %s\n", tissue_status_text(status));
        printf("%a %a %a\n", force[0], force[1], force[2]);
    }

    tissue_contact contact;
    double given_J;
    if (tissue_read_contact(tissue, &contact, sizeof contact) != TISSUE_OK || tissue_energy(tissue, "given", &given_J) != TISSUE_OK) return fail();
    fprintf(stderr, "press: %s, %d nodes, pressed with %s: %s, %.3g J from the hand\n", tissue_study(tissue), tissue_node_count(tissue),
            tissue_stiffness(tissue), contact.mesh < 0 ? "nothing" : "the tissue", -given_J);
    tissue_close(&tissue);
    return EXIT_SUCCESS;
}
