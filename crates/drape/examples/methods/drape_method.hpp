// A time integrator in C++17 for drape, over the protocol drape-method/1. One header, no libraries.
//
// Derive from drape::Method, fill in `hello`, override `step`, and call drape::serve(method) in main.
// Print what people should read to std::cerr: standard output belongs to the protocol.
#pragma once

#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace drape {

/// A JSON value.
struct Json {
    std::string text;  // of a string
    double number = 0.0;
    std::vector<Json> list;
    std::map<std::string, Json> keys;

    const Json& operator[](const std::string& key) const {
        static const Json nothing;
        auto found = keys.find(key);
        return found == keys.end() ? nothing : found->second;
    }

    static Json parse(const std::string& text) {
        const char* at = text.c_str();
        return value(at);
    }

private:
    static void space(const char*& at) {
        while (std::isspace(static_cast<unsigned char>(*at))) ++at;
    }
    static std::string string(const char*& at) {
        std::string out;
        for (++at; *at && *at != '"'; ++at) {
            if (*at == '\\' && at[1]) ++at;  // names of scenes may hold escapes: kept as they are
            out += *at;
        }
        if (*at) ++at;
        return out;
    }
    static Json value(const char*& at) {
        Json out;
        space(at);
        if (*at == '{' || *at == '[') {
            const char end = *at == '{' ? '}' : ']';
            for (++at, space(at); *at && *at != end; space(at)) {
                std::string key;
                if (end == '}') {
                    key = string(at);
                    space(at);
                    if (*at == ':') ++at;
                }
                Json member = value(at);
                if (end == '}') out.keys.emplace(key, std::move(member));
                else out.list.push_back(std::move(member));
                space(at);
                if (*at == ',') ++at, space(at);
            }
            if (*at) ++at;
        } else if (*at == '"') {
            out.text = string(at);
        } else {
            char* end = nullptr;
            out.number = std::strtod(at, &end);
            if (end == at) {  // true, false, null
                while (std::isalpha(static_cast<unsigned char>(*at))) out.text += *at++;
                if (out.text.empty()) throw std::runtime_error("drape sent no JSON");
            } else {
                at = end;
            }
        }
        return out;
    }
};

struct Spring {
    std::size_t i, j;
    double rest, stiffness, damping;
};

/// Springs, gravity and pins, and the step that a method overrides.
struct Method {
    std::string hello;  // the answer to `hello`, as JSON
    std::vector<double> mass;
    std::vector<Spring> springs;
    std::vector<std::size_t> pinned;
    std::array<double, 3> gravity{};
    bool projected = false;

    virtual ~Method() = default;
    /// Advances x (m) and v (m/s), 3 n numbers each, from t by h (s). `pins` are the places of the
    /// pinned particles at t + h.
    virtual void step(std::vector<double>& x, std::vector<double>& v, const std::vector<double>& pins,
                      double t, double h) = 0;
    virtual void restart() {}

    virtual void system(const Json& system) {
        mass.clear(), springs.clear(), pinned.clear();
        for (const Json& m : system["particles"]["mass_kg"].list) mass.push_back(m.number);
        for (const Json& s : system["springs"].list) {
            springs.push_back({static_cast<std::size_t>(s["i"].number),
                               static_cast<std::size_t>(s["j"].number), s["rest_length_m"].number,
                               s["stiffness_n_per_m"].number, s["damping_n_s_per_m"].number});
        }
        for (const Json& pin : system["pins"].list) {
            pinned.push_back(static_cast<std::size_t>(pin["particle"].number));
        }
        projected = system["damping"].text == "projected";
        gravity = {};
        const std::vector<Json>& g = system["effects"]["gravity"]["m_s2"].list;
        for (std::size_t a = 0; a < g.size() && a < 3; ++a) gravity[a] = g[a].number;
    }

    /// The force on all particles, N.
    std::vector<double> force(const std::vector<double>& x, const std::vector<double>& v) const {
        std::vector<double> f(x.size());
        for (std::size_t a = 0; a < f.size(); ++a) f[a] = mass[a / 3] * gravity[a % 3];
        for (const Spring& s : springs) {
            double d[3], w[3], length = 0.0, rate = 0.0;
            for (int a = 0; a < 3; ++a) {
                d[a] = x[3 * s.i + a] - x[3 * s.j + a];
                w[a] = v[3 * s.i + a] - v[3 * s.j + a];
                length += d[a] * d[a];
                rate += d[a] * w[a];
            }
            length = std::sqrt(length);
            const double over = length > 1e-12 * s.rest && length > 0.0 ? 1.0 / length : 0.0;
            double pull = s.stiffness * (1.0 - s.rest * over);
            if (projected) pull += s.damping * rate * over * over;
            for (int a = 0; a < 3; ++a) {
                const double part = pull * d[a] + (projected ? 0.0 : s.damping * w[a]);
                f[3 * s.i + a] -= part;
                f[3 * s.j + a] += part;
            }
        }
        return f;
    }
};

namespace detail {

inline bool line(std::string& out) {
    out.clear();
    for (int c; (c = std::getchar()) != EOF;) {
        if (c == '\n') return true;
        out += static_cast<char>(c);
    }
    return false;
}

// Byte by byte, so that the order of bytes of the machine does not matter.
inline double number(const unsigned char* bytes) {
    std::uint64_t bits = 0;
    for (int k = 7; k >= 0; --k) bits = bits << 8 | bytes[k];
    double out;
    std::memcpy(&out, &bits, sizeof out);
    return out;
}

inline void write(const std::vector<double>& values) {
    for (double value : values) {
        std::uint64_t bits;
        std::memcpy(&bits, &value, sizeof bits);
        for (int k = 0; k < 8; ++k) std::putchar(static_cast<int>(bits >> (8 * k) & 255));
    }
}

}  // namespace detail

/// Answers drape until it closes the pipe.
inline int serve(Method& method) {
    for (std::string line; detail::line(line);) {
        const Json request = Json::parse(line);
        const std::string what = request["do"].text;
        std::vector<unsigned char> bytes(static_cast<std::size_t>(request["bytes"].number));
        if (std::fread(bytes.data(), 1, bytes.size(), stdin) != bytes.size()) return 1;
        if (what == "hello") {
            std::printf("%s\n", method.hello.c_str());
        } else if (what == "step") {
            std::vector<double> all(bytes.size() / 8);
            for (std::size_t k = 0; k < all.size(); ++k) all[k] = detail::number(&bytes[8 * k]);
            const auto n = static_cast<std::ptrdiff_t>(3 * method.mass.size());
            std::vector<double> x(all.begin(), all.begin() + n);
            std::vector<double> v(all.begin() + n, all.begin() + 2 * n);
            const std::vector<double> pins(all.begin() + 2 * n, all.end());
            method.step(x, v, pins, request["time_s"].number, request["step_s"].number);
            std::printf("{\"bytes\":%zu}\n", 8 * (x.size() + v.size()));
            detail::write(x);
            detail::write(v);
        } else {
            if (what == "system") method.system(request["system"]);
            if (what == "restart") method.restart();
            std::printf("{\"ok\":true}\n");
        }
        std::fflush(stdout);
    }
    return 0;
}

}  // namespace drape
