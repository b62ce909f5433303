// SPDX-License-Identifier: Apache-2.0
#include "workbench/c_export/c_functions.h"

namespace slipstack::workbench {
namespace {

constexpr const char* kPair = R"(typedef struct {
  REAL first;
  REAL second;
} @pair;
)";

constexpr const char* kAbsolute = R"(static inline REAL @absolute(REAL x) {
  return x > (REAL)0 ? x : (REAL)0 - x;
}
)";

constexpr const char* kClamp = R"(static inline REAL @clamp(REAL x, REAL low, REAL high) {
  const REAL above = x > low ? x : low;
  return above > high ? high : above;
}
)";

constexpr const char* kFloor = R"(/* The largest whole number not above x, |x| < 2^31. */
static inline int32_t @floor(REAL x) {
  const int32_t whole = (int32_t)x;
  return whole - ((REAL)whole > x ? 1 : 0);
}
)";

constexpr const char* kInterval = R"(/* The interval of a row of `count` that 0 <= place <= count lies in. */
static inline int32_t @interval(REAL place, int32_t count) {
  const int32_t whole = (int32_t)place;
  return whole < count ? whole : count - 1;
}
)";

constexpr const char* kBitsOfFloat = R"(static inline uint32_t @bits(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline float @from_bits(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}
)";
constexpr const char* kBitsOfDouble = R"(static inline uint64_t @bits(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline double @from_bits(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}
)";

constexpr const char* kSplitOfFloat = R"(/* x as m 2^n, 1 <= m < 2: n, and m in *mantissa. */
static inline int32_t @split(float x, float *mantissa) {
  const uint32_t bits = @bits(x);
  *mantissa = @from_bits((bits & 0x007FFFFFU) | 0x3F800000U);
  return (int32_t)(bits >> 23) - 127;
}
static inline float @power_of_two(int32_t n) {
  return @from_bits((uint32_t)(n + 127) << 23);
}
)";
constexpr const char* kSplitOfDouble = R"(/* x as m 2^n, 1 <= m < 2: n, and m in *mantissa. */
static inline int32_t @split(double x, double *mantissa) {
  const uint64_t bits = @bits(x);
  *mantissa = @from_bits((bits & 0x000FFFFFFFFFFFFFU) | 0x3FF0000000000000U);
  return (int32_t)(bits >> 52) - 1023;
}
static inline double @power_of_two(int32_t n) {
  return @from_bits((uint64_t)(n + 1023) << 52);
}
)";

constexpr const char* kSplitExp2 = R"(/* 2^x as first (1 + second), |x| <= 100. */
static inline @pair @split_exp2(REAL x) {
  const REAL bounded = @clamp(x, (REAL)-100, (REAL)100);
  const int32_t whole = @floor(bounded + (REAL)0.5);
  const REAL y = (bounded - (REAL)whole) * (REAL)0.69314718055994531;
  REAL sum = (REAL)(1.0 / 5040);
  @pair out;
  sum = sum * y + (REAL)(1.0 / 720);
  sum = sum * y + (REAL)(1.0 / 120);
  sum = sum * y + (REAL)(1.0 / 24);
  sum = sum * y + (REAL)(1.0 / 6);
  sum = sum * y + (REAL)0.5;
  sum = sum * y + (REAL)1;
  out.first = @power_of_two(whole);
  out.second = sum * y;
  return out;
}
)";

constexpr const char* kExp2 = R"(static inline REAL @exp2(REAL x) {
  const @pair split = @split_exp2(x);
  return split.first * split.second + split.first;
}
)";
constexpr const char* kExp = R"(static inline REAL @exp(REAL x) {
  return @exp2(x * (REAL)1.4426950408889634);
}
)";
constexpr const char* kExpMinusOne = R"(static inline REAL @exp_minus_one(REAL x) {
  const @pair split = @split_exp2(x * (REAL)1.4426950408889634);
  return split.first * split.second + (split.first - (REAL)1);
}
)";

constexpr const char* kLog2 = R"(/* For a normal x > 0. */
static inline REAL @log2(REAL x) {
  REAL mantissa;
  int32_t exponent = @split(x, &mantissa);
  const int upper = mantissa > (REAL)1.4142135623730951;
  REAL s, s2, sum;
  mantissa = upper ? mantissa * (REAL)0.5 : mantissa;
  exponent += upper ? 1 : 0;
  s = (mantissa - (REAL)1) / (mantissa + (REAL)1);
  s2 = s * s;
  sum = (REAL)(1.0 / 9);
  sum = sum * s2 + (REAL)(1.0 / 7);
  sum = sum * s2 + (REAL)(1.0 / 5);
  sum = sum * s2 + (REAL)(1.0 / 3);
  sum = sum * s2 + (REAL)1;
  return (REAL)exponent + sum * s * (REAL)2.8853900817779268;
}
)";

constexpr const char* kPower = R"(/* base >= 0; from 1e-30 on. */
static inline REAL @power(REAL base, REAL exponent) {
  const REAL positive = base < (REAL)1e-30 ? (REAL)1e-30 : base;
  return @exp2(exponent * @log2(positive));
}
)";

constexpr const char* kSquareRoot = R"(static inline REAL @square_root(REAL a) {
  REAL root;
  if (!(a > (REAL)0)) return (REAL)0;
  root = @exp2((REAL)0.5 * @log2(a));
  root = (REAL)0.5 * (root + a / root);
  return (REAL)0.5 * (root + a / root);
}
)";

constexpr const char* kSinCos = R"(/* Sine and cosine of 2 pi cycles. */
static inline @pair @sin_cos(REAL cycles) {
  const REAL quarters = cycles * (REAL)4;
  const int32_t quadrant = @floor(quarters + (REAL)0.5);
  const REAL angle = (quarters - (REAL)quadrant) * (REAL)1.5707963267948966;
  const REAL a2 = angle * angle;
  const int swap = (quadrant & 1) != 0;
  REAL sine = (REAL)(1.0 / 362880);
  REAL cosine = (REAL)(1.0 / 40320);
  REAL s, c;
  @pair out;
  sine = sine * a2 - (REAL)(1.0 / 5040);
  sine = sine * a2 + (REAL)(1.0 / 120);
  sine = sine * a2 - (REAL)(1.0 / 6);
  sine = sine * a2 * angle + angle;
  cosine = cosine * a2 - (REAL)(1.0 / 720);
  cosine = cosine * a2 + (REAL)(1.0 / 24);
  cosine = cosine * a2 - (REAL)0.5;
  cosine = cosine * a2 + (REAL)1;
  s = swap ? cosine : sine;
  c = swap ? sine : cosine;
  out.first = (quadrant & 2) != 0 ? -s : s;
  out.second = ((quadrant + 1) & 2) != 0 ? -c : c;
  return out;
}
)";

constexpr const char* kRipple = R"(/* One period of a sum of harmonics: a parabola in each of 64 intervals. */
static inline float @ripple(const float table[64][3], float cycles) {
  const float period = cycles - (float)@floor(cycles);
  const float place = period * 64.0F;
  const int32_t whole = (int32_t)place;
  const float t = place - (float)whole;
  const float *p = table[(uint32_t)whole % 64U];
  return p[0] + (p[1] + p[2] * t) * t;
}
)";

constexpr const char* kSpeedTable =
    R"(/* Two functions of speed: parabolas, intervals even within each octave. */
static inline @pair @speed_table(const float knots[129][4], uint32_t first_bits, uint32_t shift, float velocity) {
  const uint32_t last = (128U << shift) - 1U;
  const uint32_t bits = @bits(@absolute(velocity));
  const uint32_t above = bits > first_bits ? bits - first_bits : 0U;
  const uint32_t place = above < last ? above : last;
  const float t = (float)(place & ((1U << shift) - 1U)) * (1.0F / (float)(1U << shift));
  const float *begin = knots[place >> shift];
  const float *end = knots[(place >> shift) + 1U];
  @pair out;
  out.first = begin[0] + ((end[0] - begin[0] - begin[1]) + begin[1] * t) * t;
  out.second = begin[2] + ((end[2] - begin[2] - begin[3]) + begin[3] * t) * t;
  return out;
}
)";

constexpr const char* kPowerTable =
    R"(/* A power of 2^-24 <= x < 2^8: by octave, and a parabola in each eighth of it. */
static inline float @power_table(const float octaves[32][1], const float eighths[8][3], float x) {
  const uint32_t lowest = 0x33800000U;
  const uint32_t highest = lowest + (32U << 23) - 1U;
  const uint32_t bits = @bits(x);
  const uint32_t above = bits > lowest ? bits : lowest;
  const uint32_t place = (above < highest ? above : highest) - lowest;
  const float t = (float)(place & 0xFFFFFU) * (1.0F / 1048576.0F);
  const float *p = eighths[place >> 20 & 7U];
  return (p[0] + (p[1] + p[2] * t) * t) * octaves[place >> 23][0];
}
)";

}  // namespace

std::vector<CFunction> c_functions(bool is_float) {
  return {{{"@pair "}, kPair},
          {{"@absolute("}, kAbsolute},
          {{"@clamp("}, kClamp},
          {{"@floor("}, kFloor},
          {{"@interval("}, kInterval},
          {{"@bits(", "@from_bits("}, is_float ? kBitsOfFloat : kBitsOfDouble},
          {{"@split(", "@power_of_two("}, is_float ? kSplitOfFloat : kSplitOfDouble},
          {{"@split_exp2("}, kSplitExp2},
          {{"@exp2("}, kExp2},
          {{"@exp("}, kExp},
          {{"@exp_minus_one("}, kExpMinusOne},
          {{"@log2("}, kLog2},
          {{"@power("}, kPower},
          {{"@square_root("}, kSquareRoot},
          {{"@sin_cos("}, kSinCos},
          {{"@ripple("}, kRipple},
          {{"@speed_table("}, kSpeedTable},
          {{"@power_table("}, kPowerTable}};
}

}  // namespace slipstack::workbench
