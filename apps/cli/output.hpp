#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <string_view>
#include <utility>

namespace stiction::app {

/// Before anything is printed: a reader that goes away (`| head -1`) makes writing fail and sends no signal, and a stream that the caller
/// has closed is not the next file that is opened.
void open_output();

/// Text on a stream. Work goes on where it cannot be written: close_output() says so at the end.
void say_text(std::FILE* to, std::string_view text);

template <class... T>
void say(std::FILE* to, fmt::format_string<T...> text, T&&... values) {
  say_text(to, fmt::format(text, std::forward<T>(values)...));
}

/// What was said until now is there for the reader.
void flush_text(std::FILE* to);

/// At the end. False: a part of what was to stand on stdout does not, which stderr says.
bool close_output();

}  // namespace stiction::app
