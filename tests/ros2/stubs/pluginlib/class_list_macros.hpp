#pragma once

#include <memory>
#include <type_traits>

#define PLUGINLIB_EXPORT_CLASS(type, base) static_assert(std::is_base_of_v<base, type> && std::is_default_constructible_v<type>);
