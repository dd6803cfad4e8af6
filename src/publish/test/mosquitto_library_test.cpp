#include "mqtt/mosquitto_library.hpp"

#include <gtest/gtest.h>

namespace takt::publish {
namespace mosquitto_library_test {

TEST(MosquittoLibrary, HasTheFunctionsOfVersion2) {
    EXPECT_GE(use_mosquitto_library(), 2'000'000);
    EXPECT_EQ(use_mosquitto_library(), use_mosquitto_library());
}

}  // namespace mosquitto_library_test
}  // namespace takt::publish
