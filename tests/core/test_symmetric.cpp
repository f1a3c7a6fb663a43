#include "support/test.h"

#include "vdbpack/core/rng.h"
#include "vdbpack/core/symmetric.h"

DIM_TEST_CASE("a symmetric matrix is put together from its eigenvectors") {
    RandomStream random(3, Dim);
    for (int round = 0; round < 200; ++round) {
        Matrix<Dim> m;
        for (int i = 0; i < Dim; ++i)
            for (int j = i; j < Dim; ++j) {
                // Now and then diagonal, or with equal values.
                const double x = round % 5 == 0 && i != j ? 0 : 4 * random.uniform() - 2;
                m[static_cast<std::size_t>(i)][j] = m[static_cast<std::size_t>(j)][i] =
                    round % 10 == 0 && i == j ? 1 : x;
            }
        const auto e = eigenSystem<Dim>(m);
        for (int i = 0; i + 1 < Dim; ++i) CHECK(e.values[i] >= e.values[i + 1]);
        for (int i = 0; i < Dim; ++i)
            for (int j = 0; j < Dim; ++j) {
                double sum = 0;
                for (std::size_t k = 0; k < Dim; ++k)
                    sum += e.values.c[k] * e.vectors[k][i] * e.vectors[k][j];
                CHECK(sum == Approx(m[static_cast<std::size_t>(i)][j]).margin(1e-12));
                CHECK(dot(e.vectors[static_cast<std::size_t>(i)],
                          e.vectors[static_cast<std::size_t>(j)]) ==
                      Approx(i == j ? 1 : 0).margin(1e-12));
            }
    }
}
