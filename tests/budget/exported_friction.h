/* SPDX-License-Identifier: Apache-2.0 */
/* clang-format off */
/* NOLINTBEGIN */
/* Friction model 4d8656d4 in C99, written by slipstack; SI units.
   Effects: inertia, presliding_hysteresis, coulomb, viscous, quadratic_drag, stribeck, frictional_lag, position_dependent_preload, acceleration_dependent_preload, direction_asymmetry, force_ripple, motor_constant_ripple, offset_force, cable_chain_stiffness, payload_mass, structural_resonance, time_delay, drift, user_table.
   exported_init() once, exported_step() each tick; a exported_state for each axis. No heap, no library but memcpy.
   The force is that of the slipstack firmware bit for bit where the compiler does not contract into fused products
   (-ffp-contract=off), to rounding where it does. */
#ifndef EXPORTED_H
#define EXPORTED_H

#include <stdint.h>
#include <string.h>

#define EXPORTED_MODEL_HASH 0x4d8656d4U
#define EXPORTED_STEP_M 1e-06F
/* time_delay: adds no force, is left to the caller. F(t) + T dF/dt = F_model(t - tau) */
#define EXPORTED_TIME_DELAY_DELAY 0.0002F /* s */
#define EXPORTED_TIME_DELAY_FILTER 0.0001F /* s */
#define EXPORTED_RATE_HZ 10000

/* The motion at one tick, in SI units. */
typedef struct {
  float time_s; /* since the axis runs */
  int32_t position_steps; /* in steps of 1e-06 m, absolute, from anywhere; may wrap */
  float position_m; /* on the rail, from where the model's map begins */
  float velocity_mps;
  float acceleration_mps2;
} exported_motion;

/* What the model remembers. */
typedef struct {
  float force_N; /* of the last step */
  float memory[4];
  int32_t position_steps;
  int32_t stretch_steps[10];
} exported_state;

typedef struct {
  float first;
  float second;
} exported_pair;
static inline float exported_absolute(float x) {
  return x > (float)0 ? x : (float)0 - x;
}
static inline float exported_clamp(float x, float low, float high) {
  const float above = x > low ? x : low;
  return above > high ? high : above;
}
/* The largest whole number not above x, |x| < 2^31. */
static inline int32_t exported_floor(float x) {
  const int32_t whole = (int32_t)x;
  return whole - ((float)whole > x ? 1 : 0);
}
/* The interval of a row of `count` that 0 <= place <= count lies in. */
static inline int32_t exported_interval(float place, int32_t count) {
  const int32_t whole = (int32_t)place;
  return whole < count ? whole : count - 1;
}
static inline uint32_t exported_bits(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline float exported_from_bits(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}
/* x as m 2^n, 1 <= m < 2: n, and m in *mantissa. */
static inline int32_t exported_split(float x, float *mantissa) {
  const uint32_t bits = exported_bits(x);
  *mantissa = exported_from_bits((bits & 0x007FFFFFU) | 0x3F800000U);
  return (int32_t)(bits >> 23) - 127;
}
static inline float exported_power_of_two(int32_t n) {
  return exported_from_bits((uint32_t)(n + 127) << 23);
}
/* 2^x as first (1 + second), |x| <= 100. */
static inline exported_pair exported_split_exp2(float x) {
  const float bounded = exported_clamp(x, (float)-100, (float)100);
  const int32_t whole = exported_floor(bounded + (float)0.5);
  const float y = (bounded - (float)whole) * (float)0.69314718055994531;
  float sum = (float)(1.0 / 5040);
  exported_pair out;
  sum = sum * y + (float)(1.0 / 720);
  sum = sum * y + (float)(1.0 / 120);
  sum = sum * y + (float)(1.0 / 24);
  sum = sum * y + (float)(1.0 / 6);
  sum = sum * y + (float)0.5;
  sum = sum * y + (float)1;
  out.first = exported_power_of_two(whole);
  out.second = sum * y;
  return out;
}
static inline float exported_exp2(float x) {
  const exported_pair split = exported_split_exp2(x);
  return split.first * split.second + split.first;
}
static inline float exported_exp(float x) {
  return exported_exp2(x * (float)1.4426950408889634);
}
static inline float exported_exp_minus_one(float x) {
  const exported_pair split = exported_split_exp2(x * (float)1.4426950408889634);
  return split.first * split.second + (split.first - (float)1);
}
/* For a normal x > 0. */
static inline float exported_log2(float x) {
  float mantissa;
  int32_t exponent = exported_split(x, &mantissa);
  const int upper = mantissa > (float)1.4142135623730951;
  float s, s2, sum;
  mantissa = upper ? mantissa * (float)0.5 : mantissa;
  exponent += upper ? 1 : 0;
  s = (mantissa - (float)1) / (mantissa + (float)1);
  s2 = s * s;
  sum = (float)(1.0 / 9);
  sum = sum * s2 + (float)(1.0 / 7);
  sum = sum * s2 + (float)(1.0 / 5);
  sum = sum * s2 + (float)(1.0 / 3);
  sum = sum * s2 + (float)1;
  return (float)exponent + sum * s * (float)2.8853900817779268;
}
/* base >= 0; from 1e-30 on. */
static inline float exported_power(float base, float exponent) {
  const float positive = base < (float)1e-30 ? (float)1e-30 : base;
  return exported_exp2(exponent * exported_log2(positive));
}
/* One period of a sum of harmonics: a parabola in each of 64 intervals. */
static inline float exported_ripple(const float table[64][3], float cycles) {
  const float period = cycles - (float)exported_floor(cycles);
  const float place = period * 64.0F;
  const int32_t whole = (int32_t)place;
  const float t = place - (float)whole;
  const float *p = table[(uint32_t)whole % 64U];
  return p[0] + (p[1] + p[2] * t) * t;
}
/* Two functions of speed: parabolas, intervals even within each octave. */
static inline exported_pair exported_speed_table(const float knots[129][4], uint32_t first_bits, uint32_t shift, float velocity) {
  const uint32_t last = (128U << shift) - 1U;
  const uint32_t bits = exported_bits(exported_absolute(velocity));
  const uint32_t above = bits > first_bits ? bits - first_bits : 0U;
  const uint32_t place = above < last ? above : last;
  const float t = (float)(place & ((1U << shift) - 1U)) * (1.0F / (float)(1U << shift));
  const float *begin = knots[place >> shift];
  const float *end = knots[(place >> shift) + 1U];
  exported_pair out;
  out.first = begin[0] + ((end[0] - begin[0] - begin[1]) + begin[1] * t) * t;
  out.second = begin[2] + ((end[2] - begin[2] - begin[3]) + begin[3] * t) * t;
  return out;
}
/* A power of 2^-24 <= x < 2^8: by octave, and a parabola in each eighth of it. */
static inline float exported_power_table(const float octaves[32][1], const float eighths[8][3], float x) {
  const uint32_t lowest = 0x33800000U;
  const uint32_t highest = lowest + (32U << 23) - 1U;
  const uint32_t bits = exported_bits(x);
  const uint32_t above = bits > lowest ? bits : lowest;
  const uint32_t place = (above < highest ? above : highest) - lowest;
  const float t = (float)(place & 0xFFFFFU) * (1.0F / 1048576.0F);
  const float *p = eighths[place >> 20 & 7U];
  return (p[0] + (p[1] + p[2] * t) * t) * octaves[place >> 23][0];
}
static const float exported_table_0[32][1] = {
    {3.1459552e-07F},
    {5.8705587e-07F},
    {1.0954847e-06F},
    {2.0442462e-06F},
    {3.8146973e-06F},
    {7.118475e-06F},
    {1.3283558e-05F},
    {2.4787989e-05F},
    {4.6256013e-05F},
    {8.6316744e-05F},
    {0.0001610728F},
    {0.0003005724F},
    {0.00056088815F},
    {0.0010466541F},
    {0.001953125F},
    {0.0036446615F},
    {0.0068011773F},
    {0.012691446F},
    {0.023683079F},
    {0.044194173F},
    {0.08246925F},
    {0.15389307F},
    {0.28717458F},
    {0.53588676F},
    {1.0F},
    {1.866066F},
    {3.482202F},
    {6.4980183F},
    {12.125731F},
    {22.627417F},
    {42.224243F},
    {78.79323F},
};
static const float exported_table_1[8][3] = {
    {1.0F, 0.11248517F, (-0.0006580353F)},
    {1.1118271F, 0.11117101F, (-0.00058221817F)},
    {1.2224159F, 0.11000836F, (-0.00052165985F)},
    {1.3319024F, 0.10896635F, (-0.00047159195F)},
    {1.4403968F, 0.10802305F, (-0.00043058395F)},
    {1.5479895F, 0.10716295F, (-0.00039577484F)},
    {1.654757F, 0.106372476F, (-0.00036525726F)},
    {1.760764F, 0.10564184F, (-0.00033950806F)},
};
static const float exported_table_2[129][4] = {
    {0.99992096F, 0.0F, 0.99992096F, 2.3841858e-07F},
    {0.9999106F, 2.3841858e-07F, 0.9999106F, 0.0F},
    {0.9999005F, 4.7683716e-07F, 0.9999006F, 4.7683716e-07F},
    {0.9998811F, 2.3841858e-07F, 0.999881F, 4.7683716e-07F},
    {0.99986243F, 2.3841858e-07F, 0.99986243F, 0.0F},
    {0.9998444F, 2.3841858e-07F, 0.9998443F, 4.7683716e-07F},
    {0.99982685F, 7.1525574e-07F, 0.99982685F, 4.7683716e-07F},
    {0.999793F, 4.7683716e-07F, 0.999793F, 2.3841858e-07F},
    {0.99976045F, 4.7683716e-07F, 0.99976045F, 2.3841858e-07F},
    {0.99972904F, 4.7683716e-07F, 0.9997291F, 2.3841858e-07F},
    {0.9996985F, 1.4305115e-06F, 0.9996985F, 9.536743e-07F},
    {0.9996396F, 9.536743e-07F, 0.99963963F, 7.1525574e-07F},
    {0.999583F, 9.536743e-07F, 0.99958307F, 7.1525574e-07F},
    {0.9995283F, 7.1525574e-07F, 0.9995284F, 9.536743e-07F},
    {0.9994751F, 2.3841858e-06F, 0.9994753F, 2.1457672e-06F},
    {0.99937254F, 1.66893e-06F, 0.9993728F, 1.66893e-06F},
    {0.9992741F, 1.4305115e-06F, 0.9992743F, 1.66893e-06F},
    {0.9991788F, 1.1920929e-06F, 0.9991792F, 1.1920929e-06F},
    {0.9990863F, 4.053116e-06F, 0.99908674F, 4.053116e-06F},
    {0.9989078F, 2.861023e-06F, 0.9989084F, 3.0994415e-06F},
    {0.99873644F, 2.6226044e-06F, 0.9987373F, 2.861023e-06F},
    {0.99857074F, 2.1457672e-06F, 0.99857175F, 2.1457672e-06F},
    {0.9984097F, 6.914139e-06F, 0.99841094F, 6.914139e-06F},
    {0.9980992F, 5.4836273e-06F, 0.99810106F, 5.4836273e-06F},
    {0.99780107F, 4.529953e-06F, 0.9978034F, 4.7683716e-06F},
    {0.9975128F, 3.8146973e-06F, 0.9975159F, 4.053116e-06F},
    {0.9972328F, 1.21593475e-05F, 0.9972366F, 1.21593475e-05F},
    {0.99669284F, 9.536743e-06F, 0.9966983F, 9.536743e-06F},
    {0.9961745F, 7.867813e-06F, 0.99618185F, 7.867813e-06F},
    {0.9956735F, 6.67572e-06F, 0.99568284F, 6.4373016e-06F},
    {0.9951869F, 2.1457672e-05F, 0.9951984F, 2.169609e-05F},
    {0.9942489F, 1.66893e-05F, 0.9942654F, 1.7166138e-05F},
    {0.99334884F, 1.3589859e-05F, 0.9933709F, 1.4066696e-05F},
    {0.9924792F, 1.168251e-05F, 0.9925074F, 1.21593475e-05F},
    {0.9916349F, 3.7670135e-05F, 0.99166965F, 3.862381e-05F},
    {0.9900082F, 2.9802322e-05F, 0.99005777F, 3.0517578e-05F},
    {0.98844826F, 2.4318695e-05F, 0.9885145F, 2.503395e-05F},
    {0.98694205F, 2.0503998e-05F, 0.98702663F, 2.1457672e-05F},
    {0.98548067F, 6.651878e-05F, 0.98558503F, 6.937981e-05F},
    {0.9826677F, 5.2690506e-05F, 0.98281616F, 5.507469e-05F},
    {0.97997344F, 4.339218e-05F, 0.9801713F, 4.5776367e-05F},
    {0.977375F, 3.695488e-05F, 0.97762704F, 3.862381e-05F},
    {0.97485656F, 0.00011968613F, 0.97516733F, 0.00012779236F},
    {0.97001684F, 9.536743e-05F, 0.97045743F, 0.00010204315F},
    {0.9653909F, 7.891655e-05F, 0.96597624F, 8.559227e-05F},
    {0.9609384F, 6.723404e-05F, 0.9616818F, 7.3194504e-05F},
    {0.9566314F, 0.00021958351F, 0.9575453F, 0.00024080276F},
    {0.9483778F, 0.00017595291F, 0.9496655F, 0.00019431114F},
    {0.9405172F, 0.00014638901F, 0.9422182F, 0.00016283989F},
    {0.93297756F, 0.00012540817F, 0.9351265F, 0.00014042854F},
    {0.925709F, 0.00041341782F, 0.9283368F, 0.00046420097F},
    {0.9118476F, 0.000333786F, 0.9155142F, 0.00037622452F},
    {0.8987291F, 0.00028014183F, 0.90352714F, 0.00031638145F},
    {0.88622236F, 0.00024151802F, 0.8922299F, 0.00027227402F},
    {0.87423605F, 0.00080251694F, 0.88151944F, 0.0009009838F},
    {0.8515704F, 0.00065398216F, 0.8615691F, 0.00072836876F},
    {0.83035356F, 0.00055241585F, 0.84323883F, 0.0006082058F},
    {0.8103387F, 0.00047826767F, 0.82623935F, 0.0005195141F},
    {0.7913519F, 0.0015966892F, 0.81036454F, 0.0016982555F},
    {0.7559742F, 0.0013048649F, 0.7814038F, 0.001347065F},
    {0.7234838F, 0.0011024475F, 0.7554713F, 0.001103878F},
    {0.69339263F, 0.00095272064F, 0.7319793F, 0.0009253025F},
    {0.66535175F, 0.0031609535F, 0.71051013F, 0.0029399395F},
    {0.6144242F, 0.002553463F, 0.6724635F, 0.0022478104F},
    {0.5691823F, 0.0021255016F, 0.6395683F, 0.0017793179F},
    {0.528602F, 0.0018062592F, 0.6106797F, 0.0014448166F},
    {0.4919426F, 0.0058299303F, 0.5850029F, 0.004396677F},
    {0.42825454F, 0.0045251846F, 0.54111457F, 0.0031909943F},
    {0.3748589F, 0.0036125183F, 0.50474316F, 0.0024132729F},
    {0.32956362F, 0.0029416084F, 0.47393683F, 0.0018821955F},
    {0.29079834F, 0.008903027F, 0.4474022F, 0.005436659F},
    {0.22843146F, 0.0063325167F, 0.40379256F, 0.003719449F},
    {0.18115932F, 0.0046340823F, 0.36922464F, 0.002678156F},
    {0.1447716F, 0.0034618378F, 0.3409946F, 0.0020034313F},
    {0.11642845F, 0.009247065F, 0.3174121F, 0.0055006742F},
    {0.0764767F, 0.005568877F, 0.2800517F, 0.0035600662F},
    {0.051075056F, 0.00346452F, 0.25160655F, 0.0024525523F},
    {0.03456725F, 0.0022083074F, 0.22910301F, 0.0017697215F},
    {0.023654554F, 0.004708834F, 0.2107837F, 0.004657328F},
    {0.011379193F, 0.0021006316F, 0.18261608F, 0.0028821826F},
    {0.0056345677F, 0.0009774566F, 0.16184281F, 0.0019186735F},
    {0.0028554043F, 0.0004698066F, 0.14580359F, 0.0013472438F},
    {0.0014750995F, 0.0006769416F, 0.13299587F, 0.003436625F},
    {0.00041256618F, 0.0001778052F, 0.11372536F, 0.0020596087F},
    {0.00012134487F, 4.9631548e-05F, 0.099831544F, 0.0013386607F},
    {3.715875e-05F, 1.4531433e-05F, 0.08928323F, 0.0009225607F},
    {1.1766057e-05F, 1.0759233e-05F, 0.08096974F, 0.0023044646F},
    {1.2800631e-06F, 1.1166989e-06F, 0.06864077F, 0.001352191F},
    {1.5201445e-07F, 1.274476e-07F, 0.059882782F, 0.00086535513F},
    {1.9365489e-08F, 1.5685728e-08F, 0.053305548F, 0.000589326F},
    {2.614993e-09F, 3.855683e-09F, 0.048164904F, 0.0014526546F},
    {5.4966046e-11F, 7.879686e-11F, 0.040610284F, 0.00084118545F},
    {1.3457785e-12F, 1.8829146e-12F, 0.035293225F, 0.00053316355F},
    {3.7233563e-14F, 5.0987067e-14F, 0.031326786F, 0.0003604293F},
    {1.1401076e-15F, 2.1307226e-15F, 0.028242482F, 0.00088141114F},
    {1.3691918e-18F, 2.532201e-18F, 0.023734752F, 0.000506334F},
    {2.1445532e-21F, 3.928779e-21F, 0.020579793F, 0.00031910092F},
    {4.155706e-24F, 7.547381e-24F, 0.018235676F, 0.00021478534F},
    {9.608078e-27F, 1.9114468e-26F, 0.016418422F, 0.00052270293F},
    {7.888609e-31F, 0.0F, 0.01377116F, 0.0002988726F},
    {7.888609e-31F, 0.0F, 0.011924446F, 0.00018769503F},
    {7.888609e-31F, 0.0F, 0.010555574F, 0.0001260005F},
    {7.888609e-31F, 0.0F, 0.009496267F, 0.00030583888F},
    {7.888609e-31F, 0.0F, 0.007956092F, 0.00017439947F},
    {7.888609e-31F, 0.0F, 0.0068837344F, 0.00010930933F},
    {7.888609e-31F, 0.0F, 0.006089948F, 7.3265284e-05F},
    {7.888609e-31F, 0.0F, 0.00547631F, 0.00017755292F},
    {7.888609e-31F, 0.0F, 0.004585102F, 0.000101087615F},
    {7.888609e-31F, 0.0F, 0.0039652865F, 6.3281506e-05F},
    {7.888609e-31F, 0.0F, 0.0035068456F, 4.2382628e-05F},
    {7.888609e-31F, 0.0F, 0.0031526627F, 0.0001026066F},
    {7.888609e-31F, 0.0F, 0.002638599F, 5.8359466e-05F},
    {7.888609e-31F, 0.0F, 0.0022813084F, 3.6513433e-05F},
    {7.888609e-31F, 0.0F, 0.0020171658F, 2.4440233e-05F},
    {7.888609e-31F, 0.0F, 0.0018131622F, 5.9141777e-05F},
    {7.888609e-31F, 0.0F, 0.0015171809F, 3.3622142e-05F},
    {7.888609e-31F, 0.0F, 0.0013115419F, 2.1028798e-05F},
    {7.888609e-31F, 0.0F, 0.001159553F, 1.4069956e-05F},
    {7.888609e-31F, 0.0F, 0.0010421923F, 3.4038443e-05F},
    {7.888609e-31F, 0.0F, 0.0008719551F, 1.9345433e-05F},
    {7.888609e-31F, 0.0F, 0.0007537036F, 1.2096018e-05F},
    {7.888609e-31F, 0.0F, 0.0006663171F, 8.0927275e-06F},
    {7.888609e-31F, 0.0F, 0.00059884833F, 1.957384e-05F},
    {7.888609e-31F, 0.0F, 0.0005009926F, 1.1122087e-05F},
    {7.888609e-31F, 0.0F, 0.00043302795F, 6.9533708e-06F},
    {7.888609e-31F, 0.0F, 0.00038280716F, 4.651607e-06F},
    {7.888609e-31F, 0.0F, 0.00034403568F, 1.124898e-05F},
    {7.888609e-31F, 0.0F, 0.00028780603F, 6.3910848e-06F},
    {7.888609e-31F, 0.0F, 0.00024875507F, 3.995083e-06F},
};
static const float exported_table_3[129][4] = {
    {0.99993575F, (-4.7683716e-07F), 0.99993575F, (-4.7683716e-07F)},
    {0.9999186F, (-4.7683716e-07F), 0.9999186F, (-4.7683716e-07F)},
    {0.9999005F, (-4.7683716e-07F), 0.99990046F, (-4.7683716e-07F)},
    {0.9998816F, (-1.4305115e-06F), 0.9998816F, (-1.4305115e-06F)},
    {0.9998418F, (-1.1920929e-06F), 0.9998418F, (-1.1920929e-06F)},
    {0.9997995F, (-9.536743e-07F), 0.99979955F, (-1.1920929e-06F)},
    {0.999755F, (-9.536743e-07F), 0.9997551F, (-9.536743e-07F)},
    {0.9997086F, (-3.33786e-06F), 0.9997086F, (-3.5762787e-06F)},
    {0.99961054F, (-2.861023e-06F), 0.9996106F, (-2.6226044e-06F)},
    {0.9995064F, (-2.6226044e-06F), 0.9995065F, (-2.6226044e-06F)},
    {0.9993969F, (-2.1457672e-06F), 0.99939704F, (-2.6226044e-06F)},
    {0.99928266F, (-8.106232e-06F), 0.9992829F, (-8.106232e-06F)},
    {0.9990413F, (-7.1525574e-06F), 0.99904174F, (-7.1525574e-06F)},
    {0.9987851F, (-6.198883e-06F), 0.9987858F, (-6.198883e-06F)},
    {0.99851567F, (-5.722046e-06F), 0.99851674F, (-5.722046e-06F)},
    {0.99823457F, (-1.9788742e-05F), 0.99823606F, (-1.9788742e-05F)},
    {0.9976411F, (-1.692772e-05F), 0.9976439F, (-1.7166138e-05F)},
    {0.9970111F, (-1.50203705e-05F), 0.9970156F, (-1.4305115e-05F)},
    {0.99634916F, (-1.3589859e-05F), 0.9963559F, (-1.2874603e-05F)},
    {0.9956586F, (-4.7683716e-05F), 0.99566793F, (-4.6253204e-05F)},
    {0.9942017F, (-4.1007996e-05F), 0.99421847F, (-3.9577484e-05F)},
    {0.99265665F, (-3.6001205e-05F), 0.9926835F, (-3.4570694e-05F)},
    {0.99103457F, (-3.2424927e-05F), 0.9910745F, (-3.0517578e-05F)},
    {0.98934406F, (-0.00011253357F), 0.98940045F, (-0.000104665756F)},
    {0.9857835F, (-9.584427e-05F), 0.98588365F, (-8.72612e-05F)},
    {0.9820155F, (-8.3208084e-05F), 0.9821753F, (-7.414818e-05F)},
    {0.978069F, (-7.343292e-05F), 0.978306F, (-6.365776e-05F)},
    {0.9739661F, (-0.00024914742F), 0.9742992F, (-0.00020694733F)},
    {0.96535796F, (-0.00020456314F), 0.9659443F, (-0.00015902519F)},
    {0.9562976F, (-0.00017118454F), 0.9572253F, (-0.00012278557F)},
    {0.9468625F, (-0.0001449585F), 0.94822556F, (-9.4652176e-05F)},
    {0.93711233F, (-0.0004553795F), 0.9390093F, (-0.00024700165F)},
    {0.9168501F, (-0.00033020973F), 0.9201229F, (-0.00011873245F)},
    {0.89580715F, (-0.00023508072F), 0.9008764F, (-2.5987625e-05F)},
    {0.87420154F, (-0.00015997887F), 0.8814888F, 4.2676926e-05F},
    {0.8522028F, (-0.00028944016F), 0.8621204F, 0.00045728683F},
    {0.80754673F, 5.7458878e-05F, 0.8238899F, 0.00069379807F},
    {0.7626729F, 0.00030946732F, 0.78682786F, 0.000821352F},
    {0.7181759F, 0.0004966259F, 0.75129175F, 0.00088119507F},
    {0.6744918F, 0.0027506351F, 0.7174652F, 0.0035772324F},
    {0.59077203F, 0.0033404827F, 0.6551685F, 0.003369093F},
    {0.5131957F, 0.0035934448F, 0.59984475F, 0.0030303001F},
    {0.44258708F, 0.0036258698F, 0.55092835F, 0.0026655197F},
    {0.37921995F, 0.013674974F, 0.5077073F, 0.008642316F},
    {0.2736339F, 0.011677086F, 0.43554685F, 0.006465912F},
    {0.1934787F, 0.009380698F, 0.37841693F, 0.0048621893F},
    {0.13438371F, 0.0072193146F, 0.33255118F, 0.003699541F},
    {0.09185623F, 0.01845549F, 0.29520026F, 0.010129333F},
    {0.041129164F, 0.009298421F, 0.23860437F, 0.006367147F},
    {0.017518006F, 0.004347436F, 0.19823468F, 0.004203737F},
    {0.007140655F, 0.0019137133F, 0.16829489F, 0.0028931499F},
    {0.002798169F, 0.0021387683F, 0.1453744F, 0.007096052F},
    {0.00038693327F, 0.00031947094F, 0.11290176F, 0.0040068626F},
    {4.7309866e-05F, 4.1510648e-05F, 0.09125093F, 0.0024537146F},
    {5.191373e-06F, 4.787705e-06F, 0.075938724F, 0.0015979111F},
    {5.1696964e-07F, 8.533478e-07F, 0.064619176F, 0.0036998242F},
    {3.960729e-09F, 6.73167e-09F, 0.049147684F, 0.0019793063F},
    {2.2412114e-11F, 3.8927455e-11F, 0.039182775F, 0.0011688024F},
    {9.7162546e-14F, 1.7162573e-13F, 0.032297246F, 0.00074163824F},
    {3.316929e-16F, 6.59746e-16F, 0.027290847F, 0.0016726106F},
    {2.0478617e-21F, 4.0804464e-21F, 0.02056027F, 0.0008734241F},
    {5.9952836e-27F, 1.1960208e-26F, 0.016292263F, 0.00050760433F},
    {7.888609e-31F, 0.0F, 0.013373267F, 0.00031851977F},
    {7.888609e-31F, 0.0F, 0.0112661235F, 0.0007102452F},
    {7.888609e-31F, 0.0F, 0.008453282F, 0.00036710873F},
    {7.888609e-31F, 0.0F, 0.006681362F, 0.00021192804F},
    {7.888609e-31F, 0.0F, 0.0054747155F, 0.00013236329F},
    {7.888609e-31F, 0.0F, 0.004606288F, 0.0002937708F},
    {7.888609e-31F, 0.0F, 0.0034504207F, 0.00015120208F},
    {7.888609e-31F, 0.0F, 0.0027242864F, 8.7046996e-05F},
    {7.888609e-31F, 0.0F, 0.0022306778F, 5.4258853e-05F},
    {7.888609e-31F, 0.0F, 0.0018758654F, 0.00012019789F},
    {7.888609e-31F, 0.0F, 0.0014041833F, 6.1759725e-05F},
    {7.888609e-31F, 0.0F, 0.0011081968F, 3.5515055e-05F},
    {7.888609e-31F, 0.0F, 0.0009071383F, 2.2120308e-05F},
    {7.888609e-31F, 0.0F, 0.00076268765F, 4.8962655e-05F},
    {7.888609e-31F, 0.0F, 0.0005707519F, 2.5140122e-05F},
    {7.888609e-31F, 0.0F, 0.0004503641F, 1.4450052e-05F},
    {7.888609e-31F, 0.0F, 0.00036861136F, 8.998439e-06F},
    {7.888609e-31F, 0.0F, 0.00030988798F, 1.9910047e-05F},
    {7.888609e-31F, 0.0F, 0.00023187586F, 1.021981e-05F},
    {7.888609e-31F, 0.0F, 0.00018295359F, 5.8729784e-06F},
    {7.888609e-31F, 0.0F, 0.0001497355F, 3.6567799e-06F},
    {7.888609e-31F, 0.0F, 0.00012587676F, 8.090021e-06F},
    {7.888609e-31F, 0.0F, 9.4183815e-05F, 4.152156e-06F},
    {7.888609e-31F, 0.0F, 7.431035e-05F, 2.3858447e-06F},
    {7.888609e-31F, 0.0F, 6.081691e-05F, 1.4853431e-06F},
    {7.888609e-31F, 0.0F, 5.112567e-05F, 3.2862445e-06F},
    {7.888609e-31F, 0.0F, 3.8252652e-05F, 1.6865815e-06F},
    {7.888609e-31F, 0.0F, 3.018071e-05F, 9.690702e-07F},
    {7.888609e-31F, 0.0F, 2.470023e-05F, 6.033006e-07F},
    {7.888609e-31F, 0.0F, 2.07641e-05F, 1.3347089e-06F},
    {7.888609e-31F, 0.0F, 1.5535765e-05F, 6.8504596e-07F},
    {7.888609e-31F, 0.0F, 1.2257403e-05F, 3.93582e-07F},
    {7.888609e-31F, 0.0F, 1.0031563e-05F, 2.450288e-07F},
    {7.888609e-31F, 0.0F, 8.432954e-06F, 5.421098e-07F},
    {7.888609e-31F, 0.0F, 6.309539e-06F, 2.782017e-07F},
    {7.888609e-31F, 0.0F, 4.9780847e-06F, 1.5984915e-07F},
    {7.888609e-31F, 0.0F, 4.074101e-06F, 9.951418e-08F},
    {7.888609e-31F, 0.0F, 3.424858e-06F, 2.2015956e-07F},
    {7.888609e-31F, 0.0F, 2.56248e-06F, 1.1298562e-07F},
    {7.888609e-31F, 0.0F, 2.0217378e-06F, 6.492019e-08F},
    {7.888609e-31F, 0.0F, 1.6546043e-06F, 4.0416126e-08F},
    {7.888609e-31F, 0.0F, 1.3909282e-06F, 8.941015e-08F},
    {7.888609e-31F, 0.0F, 1.0406909e-06F, 4.5886054e-08F},
    {7.888609e-31F, 0.0F, 8.210809e-07F, 2.6367388e-08F},
    {7.888609e-31F, 0.0F, 6.7197914e-07F, 1.6417061e-08F},
    {7.888609e-31F, 0.0F, 5.6489307e-07F, 3.6314304e-08F},
    {7.888609e-31F, 0.0F, 4.2265233e-07F, 1.8637706e-08F},
    {7.888609e-31F, 0.0F, 3.3346282e-07F, 1.07077085e-08F},
    {7.888609e-31F, 0.0F, 2.729082e-07F, 6.6660277e-09F},
    {7.888609e-31F, 0.0F, 2.2941778e-07F, 1.4748252e-08F},
    {7.888609e-31F, 0.0F, 1.716501e-07F, 7.568872e-09F},
    {7.888609e-31F, 0.0F, 1.354281e-07F, 4.348408e-09F},
    {7.888609e-31F, 0.0F, 1.1083511e-07F, 2.7069973e-09F},
    {7.888609e-31F, 0.0F, 9.317264e-08F, 5.989648e-09F},
    {7.888609e-31F, 0.0F, 6.9711646e-08F, 3.0740637e-09F},
    {7.888609e-31F, 0.0F, 5.5000854e-08F, 1.766125e-09F},
    {7.888609e-31F, 0.0F, 4.5013067e-08F, 1.0995791e-09F},
    {7.888609e-31F, 0.0F, 3.783987e-08F, 2.4325573e-09F},
    {7.888609e-31F, 0.0F, 2.8311744e-08F, 1.2484662e-09F},
    {7.888609e-31F, 0.0F, 2.2337302e-08F, 7.1722184e-10F},
    {7.888609e-31F, 0.0F, 1.8280973e-08F, 4.4649084e-10F},
    {7.888609e-31F, 0.0F, 1.536775e-08F, 9.879209e-10F},
    {7.888609e-31F, 0.0F, 1.1498131e-08F, 5.070042e-10F},
    {7.888609e-31F, 0.0F, 9.071768e-09F, 2.912799e-10F},
    {7.888609e-31F, 0.0F, 7.4243856e-09F, 1.813305e-10F},
    {7.888609e-31F, 0.0F, 6.2412497e-09F, 4.0122394e-10F},
    {7.888609e-31F, 0.0F, 4.669695e-09F, 2.0592061e-10F},
};
static const float exported_table_4[20] = {
    0.1F, (-0.05F), 0.2F, 0.15F, (-0.1F), 0.05F, 0.02F, 0.3F,
    (-0.2F), 0.1F, 0.07F, (-0.03F), 0.12F, 0.09F, (-0.06F), 0.01F,
    0.14F, (-0.08F), 0.03F, 0.04F,
};
static const float exported_table_5[64][3] = {
    {1.3499999F, 0.06160724F, (-0.010424137F)},
    {1.4011832F, 0.040673852F, (-0.014503956F)},
    {1.4273533F, 0.011533141F, (-0.017696857F)},
    {1.4211894F, (-0.02402544F), (-0.019680977F)},
    {1.3774834F, (-0.0635612F), (-0.02028656F)},
    {1.2936356F, (-0.10429978F), (-0.01951456F)},
    {1.1698213F, (-0.14346671F), (-0.017515182F)},
    {1.0088394F, (-0.17859608F), (-0.014557838F)},
    {0.8156856F, (-0.20776725F), (-0.010977268F)},
    {0.59694123F, (-0.22973514F), (-0.007127881F)},
    {0.36007822F, (-0.24396822F), (-0.0033227801F)},
    {0.112787224F, (-0.25056803F), 0.00020180643F},
    {(-0.13757898F), (-0.25010833F), 0.0033060312F},
    {(-0.38438126F), (-0.24344134F), 0.005957842F},
    {(-0.6218647F), (-0.23148155F), 0.008209467F},
    {(-0.84513676F), (-0.21503437F), 0.010171175F},
    {(-1.0500001F), (-0.19467878F), 0.011965275F},
    {(-1.2327132F), (-0.17074239F), 0.013691425F},
    {(-1.3897644F), (-0.14335537F), 0.015387058F},
    {(-1.5177331F), (-0.11256683F), 0.017001629F},
    {(-1.6132985F), (-0.07852626F), 0.018404007F},
    {(-1.6734207F), (-0.041651845F), 0.019391537F},
    {(-1.695681F), (-0.0027725697F), 0.019719124F},
    {(-1.6787345F), 0.036789656F, 0.019152164F},
    {(-1.6227925F), 0.07523656F, 0.017513275F},
    {(-1.5300429F), 0.11040616F, 0.014724255F},
    {(-1.4049127F), 0.1399808F, 0.0108447075F},
    {(-1.254087F), 0.16176188F, 0.0060830116F},
    {(-1.0862423F), 0.17396754F, 0.0007901192F},
    {(-0.9114849F), 0.17552465F, (-0.004573345F)},
    {(-0.74053353F), 0.16628855F, (-0.009485722F)},
    {(-0.58373064F), 0.14716625F, (-0.013435841F)},
    {(-0.45000005F), 0.12009731F, (-0.01598072F)},
    {(-0.34588352F), 0.08791086F, (-0.016819239F)},
    {(-0.27479193F), 0.05404499F, (-0.015835524F)},
    {(-0.23658243F), 0.022171482F, (-0.013122916F)},
    {(-0.22753392F), (-0.0042269826F), (-0.008984387F)},
    {(-0.24074525F), (-0.022278637F), (-0.003896594F)},
    {(-0.26692054F), (-0.030075908F), 0.0015417337F},
    {(-0.29545462F), (-0.02691546F), 0.0066845417F},
    {(-0.31568548F), (-0.013398409F), 0.010924339F},
    {(-0.31815946F), 0.008649826F, 0.013764739F},
    {(-0.2957449F), 0.036404938F, 0.01488924F},
    {(-0.24445066F), 0.06640738F, 0.014200926F},
    {(-0.16384232F), 0.09500211F, 0.011835545F},
    {(-0.057004653F), 0.11881057F, 0.008138835F},
    {0.06994476F, 0.13515405F, 0.0036225915F},
    {0.20872141F, 0.14238662F, (-0.0011080503F)},
    {0.35000002F, 0.14008388F, (-0.0054358244F)},
    {0.48464814F, 0.1290651F, (-0.008814573F)},
    {0.60489863F, 0.11124998F, (-0.010844231F)},
    {0.7053043F, 0.089363754F, (-0.011318922F)},
    {0.7833491F, 0.06654292F, (-0.010257006F)},
    {0.8396351F, 0.045888007F, (-0.007889986F)},
    {0.87763304F, 0.030027866F, (-0.0046281815F)},
    {0.90303254F, 0.020761311F, (-0.001001358F)},
    {0.9227924F, 0.018818915F, 0.0024154186F},
    {0.94402665F, 0.023772955F, 0.0050845146F},
    {0.97288394F, 0.034109354F, 0.0065789223F},
    {1.0135722F, 0.047456503F, 0.006634712F},
    {1.0676634F, 0.060911417F, 0.005191326F},
    {1.1337662F, 0.07144725F, 0.0023870468F},
    {1.2076007F, 0.07632625F, (-0.0014638901F)},
    {1.2824632F, 0.073442936F, (-0.005906582F)},
};
static const float exported_table_6[64][3] = {
    {0.027999999F, 0.0012888834F, (-0.00030852854F)},
    {0.02898036F, 0.0006688442F, (-0.00037004054F)},
    {0.029279167F, (-7.4701384e-05F), (-0.00040525198F)},
    {0.028799215F, (-0.00088873506F), (-0.00041222572F)},
    {0.02749826F, (-0.001716299F), (-0.00039245188F)},
    {0.025389506F, (-0.0025036242F), (-0.00035034865F)},
    {0.02253553F, (-0.0032058582F), (-0.00029228628F)},
    {0.01903738F, (-0.003791077F), (-0.00022548437F)},
    {0.015020816F, (-0.004241918F), (-0.00015667453F)},
    {0.010622219F, (-0.0045546144F), (-9.1243535e-05F)},
    {0.005976364F, (-0.0047361697F), (-3.238395e-05F)},
    {0.0012078104F, (-0.0048000575F), 1.9057654e-05F},
    {(-0.00357319F), (-0.004761342F), 6.432459e-05F},
    {(-0.008270206F), (-0.0046324776F), 0.00010623783F},
    {(-0.012796444F), (-0.0044202097F), 0.00014814734F},
    {(-0.017068509F), (-0.004124427F), 0.00019293278F},
    {(-0.021F), (-0.0037391111F), 0.00024210662F},
    {(-0.02449701F), (-0.0032552537F), 0.0002950281F},
    {(-0.02745724F), (-0.002665026F), 0.00034864992F},
    {(-0.029773617F), (-0.0019667745F), 0.00039776415F},
    {(-0.031342633F), (-0.0011693761F), 0.00043553114F},
    {(-0.032076478F), (-0.00029552728F), 0.00045469403F},
    {(-0.03191731F), 0.0006173644F, 0.00044858456F},
    {(-0.030851366F), 0.0015183967F, 0.00041265786F},
    {(-0.028920313F), 0.0023475774F, 0.0003453046F},
    {(-0.026227433F), 0.0030415487F, 0.000248909F},
    {(-0.022936983F), 0.0035416652F, 0.000129655F},
    {(-0.019265661F), 0.0038018748F, (-2.7269125e-06F)},
    {(-0.015466519F), 0.0037956731F, (-0.00013586879F)},
    {(-0.011806716F), 0.0035215048F, (-0.00025632232F)},
    {(-0.008541535F), 0.0030049179F, (-0.00035115704F)},
    {(-0.005887773F), 0.0022975327F, (-0.00040975958F)},
    {(-0.0039999997F), 0.001472374F, (-0.0004252419F)},
    {(-0.0029528677F), 0.00061631063F, (-0.00039554574F)},
    {(-0.0027321023F), (-0.00017962F), (-0.00032390188F)},
    {(-0.0032356246F), (-0.0008309516F), (-0.00021848362F)},
    {(-0.0042850594F), (-0.0012697126F), (-9.1608614e-05F)},
    {(-0.00564638F), (-0.0014527775F), 4.187599e-05F},
    {(-0.007057283F), (-0.0013669608F), 0.0001663696F},
    {(-0.008257874F), (-0.0010305122F), 0.0002675727F},
    {(-0.009020817F), (-0.0004905192F), 0.00033428147F},
    {(-0.009177056F), 0.00018340256F, 0.00035977736F},
    {(-0.008633877F), 0.0009081471F, 0.00034271926F},
    {(-0.007383011F), 0.0015979507F, 0.00028718263F},
    {(-0.005497877F), 0.0021753185F, 0.00020205043F},
    {(-0.0031205085F), 0.0025806928F, 9.9718105e-05F},
    {(-0.0004400981F), 0.0027796028F, (-5.643349e-06F)},
    {0.002333861F, 0.0027661277F, (-9.9989586e-05F)},
    {0.005F, 0.0025626607F, (-0.00017137267F)},
    {0.007391288F, 0.0022156658F, (-0.0002114959F)},
    {0.009395457F, 0.0017882902F, (-0.00021672994F)},
    {0.010967018F, 0.0013509346F, (-0.00018852204F)},
    {0.012129431F, 0.0009710286F, (-0.00013305992F)},
    {0.012967398F, 0.0007034838F, (-6.024912e-05F)},
    {0.013610631F, 0.0005831523F, 1.777336e-05F},
    {0.014211559F, 0.00062040426F, 8.8348985e-05F},
    {0.014920311F, 0.00080005825F, 0.0001401268F},
    {0.015860498F, 0.0010841172F, 0.00016459823F},
    {0.017109217F, 0.0014173929F, 0.00015726686F},
    {0.018683879F, 0.0017357245F, 0.000117987394F},
    {0.020537585F, 0.0019747335F, 5.106628e-05F},
    {0.022563381F, 0.0020787362F, (-3.5613775e-05F)},
    {0.024606502F, 0.0020080134F, (-0.00013178587F)},
    {0.026482724F, 0.0017435458F, (-0.00022627413F)},
};
static const float exported_table_7[33] = {
    0.01F, 0.06865478F, 0.22972657F, 0.4719751F, 0.775625F, 1.1223657F, 1.4953516F, 1.8792017F,
    2.26F, 2.6252954F, 2.9641016F, 3.266897F, 3.525625F, 3.7336938F, 3.8859766F, 3.978811F,
    4.01F, 3.978811F, 3.8859766F, 3.7336938F, 3.525625F, 3.266897F, 2.9641016F, 2.6252954F,
    2.26F, 1.8792017F, 1.4953516F, 1.1223657F, 0.775625F, 0.4719751F, 0.22972657F, 0.06865478F,
    0.01F,
};
static const int32_t exported_slip_steps[10] = {1, 2, 3, 5, 8, 13, 21, 34, 55, 300};
static const int32_t exported_stiffness[10] = {23569, 32767, 24719, 16671, 9773, 4771, 2702, 1667, 632, 213};
static inline void exported_unload(exported_state *state, int32_t position_steps) {
  int i;
  for (i = 0; i < 10; ++i) state->stretch_steps[i] = 0;
  state->position_steps = position_steps;
}
/* Stop operators: springs that slip at a distance of their own. Whole numbers: nothing is lost, nothing drifts; the
   counter may wrap. */
static inline float exported_hysteresis(exported_state *state, int32_t position_steps) {
  const int32_t moved = (int32_t)((uint32_t)position_steps - (uint32_t)state->position_steps);
  const int32_t below = moved > 32767 ? 32767 : moved;
  const int32_t travel = below < -32768 ? -32768 : below;
  int32_t sum = 0;
  int i;
  for (i = 0; i < 10; ++i) {
    const int32_t slip = exported_slip_steps[i];
    const int32_t stretched = state->stretch_steps[i] + travel;
    const int32_t limited = stretched > slip ? slip : stretched;
    const int32_t stretch = limited < -slip ? -slip : limited;
    state->stretch_steps[i] = stretch;
    sum += exported_stiffness[i] * stretch;
  }
  state->position_steps = position_steps;
  return (float)sum * 1.739555e-05F;
}

/* Begins at this motion: nothing is remembered, the hysteresis is unloaded. Not for the tick. */
static inline void exported_init(exported_state *state, const exported_motion *motion) {
  const float t1 = exported_power(exported_absolute(motion->velocity_mps) * 124.99999F, 1.3F);
  state->memory[0] = 0.0F;
  state->memory[1] = 0.0F;
  state->memory[2] = exported_exp(-t1);
  state->memory[3] = 1.0F / (1.0F + t1);
  exported_unload(state, motion->position_steps);
  (void)motion;
  state->force_N = (float)0;
}

/* One tick: the force in N that friction and inertia take, positive towards +x. The motion is that at this
   tick. */
static inline float exported_step(exported_state *state, const exported_motion *motion) {
  /* Pre-sliding hysteresis (Maxwell-slip): F = sum_i k_i z_i, z_i stop operators of slip distance D_i */
  const float presliding_hysteresis_N = exported_hysteresis(state, motion->position_steps);
  /* Coulomb friction: F = Fc sat(v / vs) */
  const float coulomb_N = 1.3F * exported_clamp(motion->velocity_mps * 5000.0F, (-1.0F), 1.0F);
  /* Inertia of the moving mass: F = m a */
  const float inertia_N = 35.0F * motion->acceleration_mps2;
  /* Viscous friction: F = c v */
  const float viscous_N = 12.0F * motion->velocity_mps;
  /* Quadratic drag: F = c2 v |v| (|v| / v1)^(n - 2), v1 = 1 m/s */
  const float t1 = exported_absolute(motion->velocity_mps);
  const float quadratic_drag_N = 3.0F * (motion->velocity_mps * exported_power_table(exported_table_0, exported_table_1, t1));
  /* Stribeck effect: friction falls with velocity: dry friction x (1 + g exp(-u) + h / (1 + u)), u = (|v|/vs)^n */
  const float t2 = presliding_hysteresis_N + coulomb_N;
  const exported_pair t3 = exported_speed_table(exported_table_2, 851443712U, 21U, motion->velocity_mps);
  const float stribeck_N = t2 * (0.15F * t3.first + 0.04F * t3.second);
  /* Frictional lag: friction follows velocity late: dry friction x (1 + q), q' = (1/tau + |v|/d) (g exp(-u) + h / (1 + u) - q), u = (|v|/vs)^n */
  const float t4 = t2 + stribeck_N;
  const float t5 = 0.005F + 0.024999999F * t1;
  const float t6 = t5 / (1.0F + 0.5F * t5);
  const float t7 = (t6 < 1.0F) ? t6 : 1.0F;
  const exported_pair t8 = exported_speed_table(exported_table_3, 916455424U, 21U, motion->velocity_mps);
  const float t9 = state->memory[2] + t7 * (t8.first - state->memory[2]);
  const float t10 = state->memory[3] + t7 * (t8.second - state->memory[3]);
  const float frictional_lag_N = t4 * (0.1F * t9 + 0.03F * t10);
  /* Preload that varies with position: dry friction x (1 + sum_j w_j B3((x - x0)/h - j)), cubic B-splines on a uniform grid */
  const float t11 = t4 + frictional_lag_N;
  const float t12 = exported_clamp(motion->position_m * 42.5F, 0.0F, 17.0F);
  const int32_t t13 = exported_interval(t12, 17);
  const float t14 = t12 - (float)t13;
  const float t15 = 1.0F - t14;
  const float t16 = t14 * t14;
  const float t17 = exported_table_4[t13] * (t15 * t15 * t15 * 0.16666667F) + exported_table_4[t13 + 1] * (0.6666667F + t16 * (0.5F * t14 - 1.0F));
  const float t18 = t16 * t14;
  const float t19 = t17 + exported_table_4[t13 + 2] * (0.16666667F + 0.5F * (t14 + t16 - t18)) + exported_table_4[t13 + 3] * (t18 * 0.16666667F);
  const float position_dependent_preload_N = t11 * t19;
  /* Preload that grows with acceleration: dry friction x (1 + b f + c f |a| / ak), f = |a| / (1 + |a| / ak) */
  const float t20 = t11 + position_dependent_preload_N;
  const float t21 = exported_absolute(motion->acceleration_mps2);
  const float t22 = t21 * 0.02F;
  const float t23 = t21 / (1.0F + t22);
  const float acceleration_dependent_preload_N = t20 * (0.004F * t23 + 0.002F * (t23 * t22));
  /* Friction that differs between the directions: dry friction x (1 + b d + e s) + c |v|, d = +1 or -1 with the sign of the dry friction, s = (3 u - u^3) / 2, u = sat(v/vs) */
  const float t24 = 2.0F * t1;
  const float t25 = t20 + acceleration_dependent_preload_N;
  const float t26 = exported_clamp(motion->velocity_mps * 10000.0F, (-1.0F), 1.0F);
  const float t27 = 0.05F * ((t2 < 0.0F) ? (-1.0F) : 1.0F) + (-0.02F) * (t26 * (1.5F - 0.5F * t26 * t26));
  const float t28 = t25 * t27;
  /* Force ripple (cogging): F = sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p), h = 1..4 */
  const float t29 = motion->position_m * 41.666668F;
  const float force_ripple_N = exported_ripple(exported_table_5, t29);
  /* Cable chain stiffness or gravity of a link: F = k (x - x0), as k x + F0, + a P2(u) + b P3(u); u = -1 .. 1 over the travel, P2 = (3 u^2 - 1)/2, P3 = (5 u^3 - 3 u)/2 */
  const float t30 = exported_clamp((motion->position_m - 0.2F) * 5.0F, (-1.0F), 1.0F);
  const float t31 = t30 * t30;
  const float cable_chain_stiffness_N = 6.0F * motion->position_m + (-1.1F) + 0.15F * (1.5F * t31 - 0.5F) + 0.3F * (t30 * (2.5F * t31 - 1.5F));
  /* Payload mass beyond the nominal mass: F = dm a */
  const float payload_mass_N = 1.5F * motion->acceleration_mps2;
  /* Structural resonance: F = r q w^2 + d q' w + e a, q'' + 2 zeta w q' + w^2 q = a, w = 2 pi f0 */
  const float t32 = state->memory[0] - motion->acceleration_mps2;
  const float t33 = motion->acceleration_mps2 + 0.9995642F * t32 + 0.029509246F * state->memory[1];
  const float t34 = 0.99838376F * state->memory[1] - 0.029509246F * t32;
  const float structural_resonance_N = 1.2F * t33 + 0.1F * t34 + 0.3F * motion->acceleration_mps2;
  /* Friction level that changes with time: dry friction x (1 + b (1 - exp(-t / tau)) / (1 - exp(-T / tau))), t at most T */
  const float t35 = t25 + t28;
  const float t36 = (-((motion->time_s < 3600.0F) ? motion->time_s : 3600.0F)) * 0.0016666667F;
  const float drift_N = t35 * ((-0.1F) * ((-exported_exp_minus_one(t36)) * 1.0024849F));
  /* Table of a user-defined effect: F = T((x - x0) n + (v - v0) m) d, T straight between 33 points; d = 1, or sat(v/vr) */
  const float t37 = exported_clamp(8000.0F * motion->position_m + 8.0F, 0.0F, 32.0F);
  const int32_t t38 = exported_interval(t37, 32);
  const float t39 = t37 - (float)t38;
  const float t40 = exported_clamp(motion->velocity_mps * 999.99994F, (-1.0F), 1.0F);
  const float user_table_N = exported_table_7[t38] * ((1.0F - t39) * t40) + exported_table_7[t38 + 1] * (t39 * t40);
  /* Motor constant that varies with position: F x (1 + sum_h A_h cos(2 pi h x / p) + B_h sin(2 pi h x / p)), h = 1..4 */
  const float t41 = inertia_N + viscous_N + quadratic_drag_N + t24 + force_ripple_N + (-0.7F);
  const float t42 = t41 + cable_chain_stiffness_N + payload_mass_N + structural_resonance_N + user_table_N;
  const float t43 = t35 + drift_N + t42;
  const float t44 = exported_ripple(exported_table_6, t29);
  const float force_N = t43 * (1.0F + t44);
  const float next_0 = t33;
  const float next_1 = t34;
  const float next_2 = t9;
  const float next_3 = t10;
  state->memory[0] = next_0;
  state->memory[1] = next_1;
  state->memory[2] = next_2;
  state->memory[3] = next_3;
  state->force_N = force_N;
  return force_N;
}

#endif
/* NOLINTEND */
