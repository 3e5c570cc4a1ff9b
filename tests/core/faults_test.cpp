#include "stiction/core/faults.hpp"

#include <gtest/gtest.h>

#include "support/message_of.hpp"

namespace stiction::core {
namespace {

TEST(Faults, AreRaisedTogether_EachOnce) {
  Faults faults;
  EXPECT_NO_THROW(faults.raise());
  for (const char* message : {"a: got 1", "a: got 1, expected 2", "a: got 1", "b"}) faults.add(message);
  EXPECT_FALSE(faults.collect([] { throw InvalidInput("b"); }));
  EXPECT_TRUE(faults.collect([] {}));
  EXPECT_EQ(test::message_of([&] { faults.raise(); }), "a: got 1\na: got 1, expected 2\nb");
}

}  // namespace
}  // namespace stiction::core
