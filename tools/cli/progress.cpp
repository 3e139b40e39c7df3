#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "tools/commands/commands.h"

namespace dualpixel::tools {
namespace {

constexpr int kBarWidth = 30;
constexpr double kRedrawSeconds = 0.1;

double now_s() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

std::string duration_text(double seconds) {
  const int whole = static_cast<int>(seconds + 0.5);
  return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {:02} s", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(std::string label)
    : label_(std::move(label)), started_s_(now_s()), terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
  if (terminal_ && !ended_ && shown_s_ > 0) std::fputc('\n', stderr);
}

void Progress::operator()(double fraction) {
  if (!terminal_ || ended_) return;
  const double now = now_s();
  ended_ = fraction >= 1;
  if (!ended_ && now - shown_s_ < kRedrawSeconds) return;
  shown_s_ = now;
  const double done = std::clamp(fraction, 0.0, 1.0);
  const int filled = static_cast<int>(done * kBarWidth);
  const double elapsed_s = now - started_s_;
  std::string time;
  if (ended_) {
    time = duration_text(elapsed_s);
  } else if (done > 0) {
    time = duration_text(elapsed_s / done * (1 - done)) + " left";
  }
  fmt::print(stderr, "\r\x1b[K{} [{}{}] {:3.0f} % {}", label_, std::string(filled, '#'),
             std::string(kBarWidth - filled, ' '), 100 * done, time);
  if (ended_) std::fputc('\n', stderr);
  std::fflush(stderr);
}

}  // namespace dualpixel::tools
