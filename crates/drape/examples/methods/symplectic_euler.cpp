// Symplectic Euler: v' = v + h f(x, v)/m, x' = x + h v'.
//
//     c++ -std=c++17 -O2 symplectic_euler.cpp -o symplectic_euler
//     drape run hanging-textile-1e4 --method program:./symplectic_euler --dt 1e-3
#include "drape_method.hpp"

struct SymplecticEuler : drape::Method {
    SymplecticEuler() {
        hello = R"({"protocol":"drape-method/1","name":"symplectic Euler in C++","order":1,)"
                R"("class":"symplectic","conserves":["momentum","angular momentum"],"implicit":false,)"
                R"("supports":["tension","shear","bending","gravity","pins","moving pins",)"
                R"("full damping","projected damping"]})";
    }

    void step(std::vector<double>& x, std::vector<double>& v, const std::vector<double>& pins,
              double, double h) override {
        const std::vector<double> f = force(x, v);
        for (std::size_t a = 0; a < x.size(); ++a) v[a] += h * f[a] / mass[a / 3];
        for (std::size_t p = 0; p < pins.size(); ++p) {
            const std::size_t a = 3 * pinned[p / 3] + p % 3;
            v[a] = (pins[p] - x[a]) / h;
        }
        for (std::size_t a = 0; a < x.size(); ++a) x[a] += h * v[a];
    }
};

int main() {
    SymplecticEuler method;
    return drape::serve(method);
}
