#include "takt/model/synonyms.hpp"

#include <gtest/gtest.h>

namespace takt::model {
namespace {

TEST(Synonyms, TheKeyThatTheObjectHas) {
    const struct {
        Object object;
        std::string_view word;
        std::string_view key;
    } cases[] = {
        {Object::device, "slave_id", "address"},
        {Object::device, "Slave_ID", "address"},
        {Object::device, "интервал", ""},
        {Object::device, "адрес", "address"},
        {Object::line, "speed", "baud"},
        {Object::line, "швидкість", "baud"},
        {Object::line, "ip", "host"},
        {Object::device, "interval", "poll_period"},
        {Object::variable, "interval", "period"},
        {Object::variable, "addr", "register"},
        {Object::device, "addr", "address"},
        {Object::variable, "factor", "scale"},
        {Object::project, "connections", "lines"},
        {Object::project, "speed", ""},
        {Object::device, "", ""},
    };
    for (const auto& [object, word, key] : cases) EXPECT_EQ(synonym(object, word), key) << word;
}

}  // namespace
}  // namespace takt::model
