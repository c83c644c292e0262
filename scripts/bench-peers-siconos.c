/* Solves a square flat punch, pressed into an elastic half-space in one step, with Siconos, for
   scripts/bench-peers, as a dense three-dimensional frictional contact problem.
   Usage: bench-peers-siconos METHOD N TOLERANCE, where METHOD is nsn or nsgs.

   The scene has side 2, G = 1, nu = mu = 0.3, approach 0.01 and N by N elements of constant
   traction, with displacements at their centres (the midpoint projection). Siconos looks for
   tractions r with u = M r + q, 0 <= u_N orthogonal to r_N >= 0 and, where there is slip,
   r_T = -mu r_N u_T / |u_T|. Here M is the matrix of influence coefficients, q_N = -approach, and
   u is gap and slip.

   The program prints the seconds, the relative residual of the natural map as tribosweep's
   certificate defines it, and the load. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <numerics/FrictionContactProblem.h>
#include <numerics/Friction_cst.h>
#include <numerics/NonSmoothDrivers.h>
#include <numerics/NumericsMatrix.h>
#include <numerics/SolverOptions.h>

static const double NU = 0.3, MU = 0.3, SIDE = 2.0, APPROACH = 0.01;

static double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

/* Computes the displacements (z, x, y) at (x, y) from unit tractions (z, x, y) on the square of
   side h around the origin, G = 1: Boussinesq's and Cerruti's kernels are integrated in closed
   form. Corners never lie on an axis, so that nothing is singular. */
static void influence(double x, double y, double h, double a[3][3]) {
    double inv_r = 0, xx = 0, yy = 0, xy = 0, dx = 0, dy = 0;
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) {
            double s = i == j ? 1 : -1;
            double u = x + (i - 0.5) * h, v = y + (j - 0.5) * h, r = hypot(u, v);
            double f = u * asinh(v / fabs(u)), g = v * asinh(u / fabs(v));
            inv_r += s * (f + g);
            xx += s * g;
            yy += s * f;
            xy -= s * r;
            dx += s * (v * log(r) + u * atan(v / u));
            dy += s * (u * log(r) + v * atan(u / v));
        }
    double whole = 1 / (2 * M_PI), coupled = (1 - 2 * NU) / (4 * M_PI);
    a[0][0] = whole * (1 - NU) * inv_r;
    a[1][1] = whole * ((1 - NU) * inv_r + NU * xx);
    a[2][2] = whole * ((1 - NU) * inv_r + NU * yy);
    a[1][2] = a[2][1] = whole * NU * xy;
    a[0][1] = coupled * dx;
    a[0][2] = coupled * dy;
    a[1][0] = -a[0][1];
    a[2][0] = -a[0][2];
}

int main(int argc, char **argv) {
    int method = argc == 4 && !strcmp(argv[1], "nsn")    ? SICONOS_FRICTION_3D_NSN_AC
                 : argc == 4 && !strcmp(argv[1], "nsgs") ? SICONOS_FRICTION_3D_NSGS
                                                         : 0;
    int n = argc == 4 ? atoi(argv[2]) : 0;
    double tolerance = argc == 4 ? atof(argv[3]) : 0;
    if (!method || n < 1 || n > 100 || !(tolerance > 0)) {
        fprintf(stderr, "usage: bench-peers-siconos nsn|nsgs N TOLERANCE, N up to 100\n");
        return 1;
    }
    double start = seconds(), h = SIDE / n;
    int contacts = n * n, size = 3 * contacts;
    NumericsMatrix *matrix = NM_create(NM_DENSE, size, size);
    double *q = calloc(size, sizeof *q), *mu = malloc(contacts * sizeof *mu);
    double *p = calloc(size, sizeof *p), *u = calloc(size, sizeof *u);
    /* All entries come from the coefficients of the (2n - 1)^2 distances. */
    double(*table)[3][3] = malloc(sizeof(*table) * (2 * n - 1) * (2 * n - 1));
    for (int i = 1 - n; i < n; i++)
        for (int j = 1 - n; j < n; j++)
            influence(i * h, j * h, h, table[(i + n - 1) * (2 * n - 1) + j + n - 1]);
    for (int to = 0; to < contacts; to++)
        for (int from = 0; from < contacts; from++) {
            int i = to / n - from / n, j = to % n - from % n;
            double(*a)[3] = table[(i + n - 1) * (2 * n - 1) + j + n - 1];
            for (int row = 0; row < 3; row++)
                for (int column = 0; column < 3; column++)
                    matrix->matrix0[(size_t)(3 * from + column) * size + 3 * to + row] =
                        a[row][column];
        }
    free(table);
    for (int e = 0; e < contacts; e++) {
        q[3 * e] = -APPROACH;
        mu[e] = MU;
    }
    double pull = 1 / fmax(matrix->matrix0[0], fmax(matrix->matrix0[size + 1],
                                                    matrix->matrix0[2 * (size_t)size + 2]));

    FrictionContactProblem *problem =
        frictionContactProblem_new_with_data(3, contacts, matrix, q, mu);
    SolverOptions *options = solver_options_create(method);
    options->iparam[SICONOS_IPARAM_MAX_ITER] = 100000;
    options->dparam[SICONOS_DPARAM_TOL] = tolerance;
    double assembled = seconds();
    int failed = fc3d_driver(problem, p, u, options);
    double solved = seconds();

    double defect = 0, norm = 0, load = 0;
    for (int e = 0; e < size; e++) u[e] = q[e];
    for (int column = 0; column < size; column++)
        for (int row = 0; row < size; row++)
            u[row] += matrix->matrix0[(size_t)column * size + row] * p[column];
    for (int e = 0; e < contacts; e++) {
        double *r = p + 3 * e, *w = u + 3 * e;
        double normal = fmax(0, r[0] - pull * w[0]);
        double x = r[1] - pull * w[1], y = r[2] - pull * w[2];
        double traction = hypot(x, y), shrink = traction > MU * normal ? MU * normal / traction : 1;
        defect += pow(r[0] - normal, 2) + pow(r[1] - shrink * x, 2) + pow(r[2] - shrink * y, 2);
        norm += r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
        load += r[0] * h * h;
    }
    printf("{\"seconds\": %.6f, \"assembly_seconds\": %.6f, \"residual\": %.3e, \"result\": %.15g, "
           "\"iterations\": %d, \"failed\": %d}\n",
           solved - start, assembled - start, sqrt(defect / norm), load,
           options->iparam[SICONOS_IPARAM_ITER_DONE], failed);
    return 0;
}
