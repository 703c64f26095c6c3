// SPDX-License-Identifier: Apache-2.0
#include "terminal/keys.hpp"

#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace vdrive::tool {
namespace {

struct KeyCode {
  std::string_view code;
  Key key;
};

constexpr std::array kCodes{
    KeyCode{"s", Key::sort},
    KeyCode{"r", Key::reverse},
    KeyCode{"f", Key::faults},
    KeyCode{" ", Key::next_page},
    KeyCode{"b", Key::previous_page},
    KeyCode{"g", Key::first_page},
    KeyCode{"q", Key::quit},
    KeyCode{"\x1b[6~", Key::next_page},
    KeyCode{"\x1b[5~", Key::previous_page},
    KeyCode{"\x1b[B", Key::next_page},
    KeyCode{"\x1b[A", Key::previous_page},
    KeyCode{"\x1b[H", Key::first_page},
    KeyCode{"\x1b[1~", Key::first_page},
};

/// The previous state of the terminal, to restore it from any thread when the process ends. Written
/// before the flag is set.
termios& former_state() {
  static termios state{};
  return state;
}

std::atomic<bool>& is_changed() {
  static std::atomic<bool> changed = false;
  return changed;
}

}  // namespace

std::optional<Key> take_key(std::string& typed) {
  while (!typed.empty()) {
    const auto* const code = std::ranges::find_if(kCodes, [&](const KeyCode& each) {
      return typed.starts_with(each.code);
    });
    if (code != kCodes.end()) {
      typed.erase(0, code->code.size());
      return code->key;
    }
    const bool is_a_beginning = std::ranges::any_of(kCodes, [&](const KeyCode& each) {
      return each.code.starts_with(typed);
    });
    if (is_a_beginning) return std::nullopt;
    typed.erase(0, 1);
  }
  return std::nullopt;
}

KeyInput::KeyInput() {
  if (isatty(STDIN_FILENO) != 1 || tcgetattr(STDIN_FILENO, &former_state()) != 0) return;
  // A background process would be stopped if it changed the terminal.
  if (tcgetpgrp(STDIN_FILENO) != getpgrp()) return;
  termios state = former_state();
  state.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  state.c_cc[VMIN] = 0;  // read() does not wait
  state.c_cc[VTIME] = 0;
  is_changed() = true;
  is_active_ = tcsetattr(STDIN_FILENO, TCSANOW, &state) == 0;
}

KeyInput::~KeyInput() {
  restore_at_once();
}

void KeyInput::restore_at_once() noexcept {
  if (!is_changed().exchange(false)) return;
  // A failure cannot be handled any more.
  static_cast<void>(tcsetattr(STDIN_FILENO, TCSANOW, &former_state()));
}

std::optional<Key> KeyInput::next() {
  if (!is_active_) return std::nullopt;
  std::array<char, 64> text{};
  const ssize_t length = read(STDIN_FILENO, text.data(), text.size());
  if (length > 0) typed_.append(text.data(), static_cast<std::size_t>(length));
  return take_key(typed_);
}

}  // namespace vdrive::tool
