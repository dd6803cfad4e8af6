// A libmodbus master that tries every function it has on a device filled with the ramp (register a holds a,
// bit a holds a & 1), and reports each difference.
//
// usage: libmodbus_client tcp HOST PORT UNIT | libmodbus_client rtu DEVICE BAUD PARITY(N|E|O) UNIT
#include <modbus/modbus.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

int failures = 0;

void expect(bool holds, const std::string& what) {
    if (holds) return;
    ++failures;
    std::printf("wrong: %s (%s)\n", what.c_str(), modbus_strerror(errno));
}

using Registers = std::vector<std::uint16_t>;
using Bits = std::vector<std::uint8_t>;
using ReadRegisters = int (*)(modbus_t*, int, int, std::uint16_t*);
using ReadBits = int (*)(modbus_t*, int, int, std::uint8_t*);

Registers registers(modbus_t* bus, ReadRegisters read, int address, int count, const std::string& what) {
    Registers values(static_cast<std::size_t>(count));
    expect(read(bus, address, count, values.data()) == count, what);
    return values;
}

Bits bits(modbus_t* bus, ReadBits read, int address, int count, const std::string& what) {
    Bits values(static_cast<std::size_t>(count));
    expect(read(bus, address, count, values.data()) == count, what);
    return values;
}

void read_ramps(modbus_t* bus) {
    for (const int count : {1, 2, 7, 8, 9, 125}) {
        for (const auto read : {modbus_read_registers, modbus_read_input_registers}) {
            const auto what = "read " + std::to_string(count) + " registers";
            const auto values = registers(bus, read, 300, count, what);
            for (int i = 0; i < count; ++i) expect(values[static_cast<std::size_t>(i)] == 300 + i, what);
        }
    }
    for (const int count : {1, 7, 8, 9, 16, 17, 2000}) {
        for (const auto read : {modbus_read_bits, modbus_read_input_bits}) {
            const auto what = "read " + std::to_string(count) + " bits";
            const auto values = bits(bus, read, 31, count, what);
            for (int i = 0; i < count; ++i)
                expect(values[static_cast<std::size_t>(i)] == ((31 + i) & 1), what);
        }
    }
}

void write_one(modbus_t* bus) {
    for (const int on : {1, 0, 1}) {
        expect(modbus_write_bit(bus, 4000, on) == 1, "0x05");
        expect(bits(bus, modbus_read_bits, 4000, 1, "0x05 read back")[0] == on, "0x05 value");
    }
    for (const std::uint16_t value : {std::uint16_t{0}, std::uint16_t{0x1234}, std::uint16_t{0xFFFF}}) {
        expect(modbus_write_register(bus, 4000, value) == 1, "0x06");
        expect(registers(bus, modbus_read_registers, 4000, 1, "0x06 read back")[0] == value, "0x06 value");
    }
}

void write_many(modbus_t* bus) {
    for (const int count : {1, 9, 123}) {
        Registers values;
        for (int i = 0; i < count; ++i) values.push_back(static_cast<std::uint16_t>(50000 + 7 * i));
        const auto what = "0x10 with " + std::to_string(count);
        expect(modbus_write_registers(bus, 5000, count, values.data()) == count, what);
        expect(registers(bus, modbus_read_registers, 5000, count, what) == values, what + ", values");
    }
    for (const int count : {1, 8, 11, 1968}) {
        Bits values;
        for (int i = 0; i < count; ++i) values.push_back(static_cast<std::uint8_t>(i % 3 == 0));
        const auto what = "0x0F with " + std::to_string(count);
        expect(modbus_write_bits(bus, 5003, count, values.data()) == count, what);
        expect(bits(bus, modbus_read_bits, 5003, count, what) == values, what + ", values");
        expect(bits(bus, modbus_read_bits, 5003 + count, 1, what)[0] == ((5003 + count) & 1),
               what + ", the one beyond");
    }
}

void mask_and_exchange(modbus_t* bus) {
    expect(modbus_write_register(bus, 6000, 0x0012) == 1, "0x16, before");
    expect(modbus_mask_write_register(bus, 6000, 0x00F2, 0x0025) == 1, "0x16");
    expect(registers(bus, modbus_read_registers, 6000, 1, "0x16")[0] == 0x0017,
           "0x16, the specification's example");
    Registers values(121), read(125);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(0xA000 + i);
    expect(modbus_write_and_read_registers(bus, 7000, 121, values.data(), 6999, 125, read.data()) == 125,
           "0x17");
    expect(read[0] == 6999 && read[1] == 0xA000 && read[121] == 0xA000 + 120 && read[122] == 7121,
           "0x17 writes before it reads");
}

void exceptions(modbus_t* bus) {
    Registers values(2);
    Bits single(1);
    expect(modbus_read_registers(bus, 65535, 2, values.data()) == -1 && errno == EMBXILADD,
           "exception 2 beyond the end");
    expect(modbus_write_registers(bus, 65535, 2, values.data()) == -1 && errno == EMBXILADD,
           "exception 2 for 0x10");
    expect(modbus_read_registers(bus, 65535, 1, values.data()) == 1 && values[0] == 65535,
           "the last register");
    expect(modbus_read_bits(bus, 65535, 1, single.data()) == 1 && single[0] == 1, "the last coil");
    std::array<std::uint8_t, 64> identity{};
    expect(modbus_report_slave_id(bus, 64, identity.data()) >= 0 || errno == EMBXILFUN, "0x11 is answered");
}

}  // namespace

int main(int argc, char** argv) {
    const std::string kind = argc > 1 ? argv[1] : "";
    if (!(kind == "tcp" && argc == 5) && !(kind == "rtu" && argc == 6)) return 2;
    modbus_t* bus = kind == "tcp" ? modbus_new_tcp(argv[2], std::atoi(argv[3]))
                                  : modbus_new_rtu(argv[2], std::atoi(argv[3]), argv[4][0], 8, 1);
    modbus_set_slave(bus, std::atoi(argv[argc - 1]));
    modbus_set_response_timeout(bus, 10, 0);  // long, so that a busy machine does not look like "no answer"
    modbus_set_byte_timeout(bus, 5, 0);
    if (modbus_connect(bus) != 0) {
        std::printf("cannot connect: %s\n", modbus_strerror(errno));
        return 3;
    }
    read_ramps(bus);
    write_one(bus);
    write_many(bus);
    mask_and_exchange(bus);
    exceptions(bus);
    modbus_close(bus);
    modbus_free(bus);
    std::printf("%d wrong\n", failures);
    return failures == 0 ? 0 : 1;
}
