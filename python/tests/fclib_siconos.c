/* Reads a problem with FCLIB's own reader, solves it with Siconos from nothing, and prints as JSON
   how far the solution in the file is from Siconos' one.
   Usage: fclib_siconos FILE */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include <fclib.h>

#include <numerics/FrictionContactProblem.h>
#include <numerics/Friction_cst.h>
#include <numerics/NonSmoothDrivers.h>
#include <numerics/NumericsMatrix.h>
#include <numerics/SolverOptions.h>

/* Returns the largest difference of two vectors over the largest entry of the first. */
static double difference(const double *a, const double *b, int size) {
    double apart = 0, largest = 0;
    for (int i = 0; i < size; i++) {
        apart = fmax(apart, fabs(a[i] - b[i]));
        largest = fmax(largest, fabs(a[i]));
    }
    return apart / largest;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: fclib_siconos FILE\n");
        return 1;
    }
    struct fclib_local *local = fclib_read_local(argv[1]);
    struct fclib_solution *solution = fclib_read_solution(argv[1]);
    if (!local || !solution || local->spacedim != 3 || local->W->nz != -1) {
        fprintf(stderr, "no local problem in three dimensions with its solution\n");
        return 1;
    }
    int size = local->W->n, contacts = size / 3;
    NumericsMatrix *matrix = NM_create(NM_DENSE, size, size);
    for (int column = 0; column < size; column++)
        for (int place = local->W->p[column]; place < local->W->p[column + 1]; place++)
            matrix->matrix0[(size_t)column * size + local->W->i[place]] = local->W->x[place];
    double *r = calloc(size, sizeof *r), *u = calloc(size, sizeof *u);
    double *q = malloc(size * sizeof *q);
    for (int i = 0; i < size; i++) q[i] = local->q[i];
    FrictionContactProblem *problem =
        frictionContactProblem_new_with_data(3, contacts, matrix, q, local->mu);
    SolverOptions *options = solver_options_create(SICONOS_FRICTION_3D_NSN_AC);
    options->iparam[SICONOS_IPARAM_MAX_ITER] = 1000;
    options->dparam[SICONOS_DPARAM_TOL] = 1e-12;
    int failed = fc3d_driver(problem, r, u, options);
    /* The solver's own u is not needed to the last digit. */
    for (int i = 0; i < size; i++) u[i] = local->q[i];
    for (int column = 0; column < size; column++)
        for (int row = 0; row < size; row++)
            u[row] += matrix->matrix0[(size_t)column * size + row] * r[column];
    printf("{\"failed\": %d, \"iterations\": %d, \"forces_apart\": %.3e, "
           "\"displacements_apart\": %.3e, \"merit\": %.3e, \"contacts\": %d}\n",
           failed, options->iparam[SICONOS_IPARAM_ITER_DONE], difference(r, solution->r, size),
           difference(u, solution->u, size), fclib_merit_local(local, MERIT_1, solution), contacts);
    return 0;
}
