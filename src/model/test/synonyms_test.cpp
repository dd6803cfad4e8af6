#include "takt/model/synonyms.hpp"

#include <gtest/gtest.h>

namespace takt::model {
namespace synonyms_test {

TEST(Synonyms, TheKeyThatTheObjectHas) {
    const struct {
        Object object;
        std::string_view word;
        std::string_view key;
    } cases[] = {
        {Object::variable, "discrete_input", "coil"},
        {Object::variable, "input_register", "register"},
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
        {Object::variable, "adress", "register"},
        {Object::variable, "word_swap", "byte_order"},
        {Object::project, "speed", ""},
        {Object::device, "", ""},
    };
    for (const auto& [object, word, key] : cases) EXPECT_EQ(synonym(object, word), key) << word;
}

TEST(Synonyms, TheValueThatIsMeant) {
    const struct {
        Object object;
        std::string_view key;
        std::string_view value;
        std::string_view word;
    } cases[] = {
        {Object::line, "parity", "E", "even"},          {Object::line, "parity", "n", "none"},
        {Object::line, "parity", "чет", "even"},        {Object::line, "parity", "mark", ""},
        {Object::variable, "type", "DWORD", "uint32"},  {Object::variable, "type", "ціле", "int16"},
        {Object::variable, "type", "BYTE", "uint16"},   {Object::variable, "area", "hr", "holding_register"},
        {Object::line, "transport", "ethernet", "tcp"}, {Object::line, "transport", "e", ""},
    };
    for (const auto& [object, key, value, word] : cases)
        EXPECT_EQ(value_synonym(key, find_field(object, key)->words, value), word) << value;
}

}  // namespace synonyms_test
}  // namespace takt::model
