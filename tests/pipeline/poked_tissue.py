"""poked_tissue.py MEASURED POKES: writes two CSV files of synthetic measured contacts. MEASURED: a tissue with 50 N/m
along the normal and 30 N/m across it at every contact. POKES: a target tissue that is 1.5 times as stiff in its left
half."""
import sys
header = "contact_x [mm],contact_y [mm],displacement_x [mm],displacement_y [mm],force_x [mN],force_y [mN]"
def rows(factor, shift):
    for i in range(24):
        x, y, n = [(100, 20 + 10 * i + shift, (-1, 0)), (100 - 10 * (i - 8) - shift, 100, (0, -1)), (0, 100 - 10 * (i - 16) - shift, (1, 0))][i // 8]
        for across in (-2, 2):
            u = [5 * n[0] - across * n[1], 5 * n[1] + across * n[0]]
            f = [factor(x) * (250 * n[0] - 30 * across * n[1]), factor(x) * (250 * n[1] + 30 * across * n[0])]
            yield f"{x},{y},{u[0]},{u[1]},{f[0]:.3f},{f[1]:.3f}"
open(sys.argv[1], "w").write("\n".join([header, *rows(lambda x: 1, 0)]) + "\n")
patient = list(rows(lambda x: 1.5 if x < 50 else 1, 3))
open(sys.argv[2], "w").write("\n".join([header, *(patient[(7 * i) % len(patient)] for i in range(len(patient)))]) + "\n")
