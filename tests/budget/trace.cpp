// SPDX-License-Identifier: Apache-2.0
// The same random motion through every observer, on host and target: what it prints is compared line by line.
//
//   trace                       for each observer: a checksum for every block of 1000 steps
//   trace OBSERVER BLOCK        for each step of that block: position and the force's bits
//
// On the target the words come from the emulator (semihosting); on the host from the command line.
#include <cstdint>
#include <cstring>

#include "tests/budget/motion.h"
#include "tests/budget/observers.h"

#if defined(__arm__)
#include "hal/mps2/semihosting.h"
#include "hal/mps2/uart.h"
#else
#include <cstdio>
#include <string>
#endif

namespace {

using slipstack::budget::kObservers;
using slipstack::budget::Observer;
using slipstack::budget::RandomMotion;

constexpr std::uint32_t kSteps = 100000;
constexpr std::uint32_t kBlock = 1000;
constexpr std::int32_t kStart = 2147480000;  // near the end of the counter: it wraps around on the way

#if defined(__arm__)
using slipstack::mps2::uart_write;
using slipstack::mps2::uart_write_hex;
using slipstack::mps2::uart_write_unsigned;
void write(const char* text) {
  uart_write(text);
}
void write_hex(std::uint32_t value) {
  uart_write_hex(value);
}
void write_unsigned(std::uint32_t value) {
  uart_write_unsigned(value);
}
#else
void write(const char* text) {
  std::fputs(text, stdout);
}
void write_hex(std::uint32_t value) {
  std::printf("%08x", value);
}
void write_unsigned(std::uint32_t value) {
  std::printf("%u", value);
}
#endif

float step(const Observer& observer, std::int32_t x) {
  if (observer.before != nullptr) observer.before(x);
  return observer.step(x);
}

std::uint32_t bits(float value) {
  std::uint32_t word = 0;
  std::memcpy(&word, &value, sizeof word);
  return word;
}

// FNV-1a over words: any changed bit changes it.
std::uint32_t mix(std::uint32_t checksum, std::uint32_t word) {
  return (checksum ^ word) * 16777619U;
}

void print_checksums(const Observer& observer) {
  RandomMotion motion(0xC0FFEE11, kStart);
  observer.reset(kStart);
  std::uint32_t checksum = 2166136261U;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const std::int32_t x = motion.next();
    checksum = mix(mix(checksum, static_cast<std::uint32_t>(x)), bits(step(observer, x)));
    if ((i + 1) % kBlock != 0) continue;
    write("block ");
    write(observer.name);
    write(" ");
    write_unsigned(i / kBlock);
    write(" ");
    write_hex(checksum);
    write("\n");
  }
}

void print_block(const Observer& observer, std::uint32_t block) {
  RandomMotion motion(0xC0FFEE11, kStart);
  observer.reset(kStart);
  for (std::uint32_t i = 0; i < kSteps && i < (block + 1) * kBlock; ++i) {
    const std::int32_t x = motion.next();
    const float force_N = step(observer, x);
    if (i / kBlock != block) continue;
    write("step ");
    write_unsigned(i);
    write(" ");
    write_hex(static_cast<std::uint32_t>(x));
    write(" ");
    write_hex(bits(force_N));
    write("\n");
  }
}

// Runs what "OBSERVER BLOCK" asks for, or all checksums for an empty text. Returns the exit status.
int run(const char* request) {
  if (!slipstack::budget::set_up_observers()) return 1;
  if (*request == '\0') {
    for (const Observer& observer : kObservers) print_checksums(observer);
    return 0;
  }
  for (const Observer& observer : kObservers) {
    const std::size_t length = std::strlen(observer.name);
    if (std::strncmp(request, observer.name, length) != 0 || request[length] != ' ') continue;
    std::uint32_t block = 0;
    for (const char* c = request + length + 1; *c >= '0' && *c <= '9'; ++c) {
      block = block * 10 + static_cast<std::uint32_t>(*c - '0');
    }
    print_block(observer, block);
    return 0;
  }
  write("no such observer\n");
  return 2;
}

}  // namespace

#if defined(__arm__)
int main() {
  char buffer[128];
  // The first word is the name of the image.
  const char* request = slipstack::mps2::command_line(buffer);
  while (*request != '\0' && *request != ' ') ++request;
  while (*request == ' ') ++request;
  return run(request);
}
#else
int main(int argc, char** argv) {
  std::string request;
  for (int i = 1; i < argc; ++i) {
    if (i > 1) request += ' ';
    request += argv[i];
  }
  return run(request.c_str());
}
#endif
