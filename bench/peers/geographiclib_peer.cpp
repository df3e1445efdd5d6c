// GeographicLib's sum of harmonics with the coefficients of data/egm96_deg70.gfc: for bench/peers.py.
//     geographiclib_peer GFC DEGREE
#include <GeographicLib/SphericalHarmonic.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

int main(int, char **argv) {
    const int N = std::atoi(argv[2]);
    double gm = 0, radius = 0;
    // column by column of the order, as GeographicLib wants them
    auto at = [N](int n, int m) { return m * N - m * (m - 1) / 2 + n; };
    std::vector<double> C((N + 1) * (N + 2) / 2, 0.0), S((N + 1) * (N + 2) / 2, 0.0);
    std::ifstream file(argv[1]);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        if (key == "earth_gravity_constant") words >> gm;
        if (key == "radius") words >> radius;
        if (key != "gfc") continue;
        int n, m;
        double c, s;
        words >> n >> m >> c >> s;
        if (n > N) continue;
        C[at(n, m)] = c;
        if (m > 0) S[at(n, m) - (N + 1)] = s;
    }
    C[0] = 1;
    const GeographicLib::SphericalHarmonic sum(C, S, N, radius);
    const double pi = 3.14159265358979323846, r = 6.838e6;
    std::vector<double> x(1000), y(1000), z(1000);
    for (int i = 1; i <= 1000; i++) {
        const double a = 2 * pi * std::fmod(i * 0.618034, 1.0);
        const double b = 2 * pi * (std::fmod(i * 0.381966 * 0.5, 0.5) - 0.25) * 0.98;
        x[i - 1] = r * (std::cos(b) * std::cos(a));
        y[i - 1] = r * (std::cos(b) * std::sin(a));
        z[i - 1] = r * std::sin(b);
    }
    const double scale = gm / radius;
    const int calls = 400000 / N;
    double best = 1e9, total = 0, gx, gy, gz;
    for (int repeat = 0; repeat < 5; repeat++) {
        const auto start = std::chrono::steady_clock::now();
        for (int k = 1; k <= calls; k++) {
            const int i = k % 1000;
            sum(x[i], y[i], z[i], gx, gy, gz);
            total += scale * gx;
        }
        const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
        best = std::min(best, took.count() / calls);
    }
    std::printf("seconds %.6e\n", best);
    for (int i = 0; i < 5; i++) {
        sum(x[i], y[i], z[i], gx, gy, gz);
        std::printf("value %.16e %.16e %.16e\n", scale * gx, scale * gy, scale * gz);
    }
    return total == 1e300;
}
