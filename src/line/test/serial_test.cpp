// Serial ports and their driver on real pseudo-terminals.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "folder.hpp"
#include "serial/receive_trigger.hpp"
#include "support.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/real_line.hpp"
#include "takt/line/serial_port.hpp"

namespace takt::line {
namespace serial_test {

SerialSettings settings_of(const std::string& path) {
    SerialSettings settings;
    settings.path = path;
    settings.format = {115200, 8, wire::Parity::none, 1};
    return settings;
}

termios settings_now(const Pty& pty) {
    termios settings{};
    EXPECT_EQ(::tcgetattr(pty.slave.get(), &settings), 0);
    return settings;
}

TEST(SerialPort, IsRawAndGivesTheSettingsBack) {
    const Pty pty;
    const termios before = settings_now(pty);
    ASSERT_NE(before.c_lflag & ICANON, 0u);
    {
        const auto port = SerialPort::open(settings_of(pty.path));
        ASSERT_TRUE(port) << name(port.error().code);
        const termios during = settings_now(pty);
        EXPECT_EQ(during.c_lflag & (ICANON | ECHO | ISIG), 0u);
        EXPECT_EQ(during.c_oflag & OPOST, 0u);
        EXPECT_EQ(::cfgetospeed(&during), speed_t{B115200});
        EXPECT_EQ((*port)->rs485(), model::Rs485::none);
    }
    const termios after = settings_now(pty);
    EXPECT_EQ(before.c_iflag, after.c_iflag);
    EXPECT_EQ(before.c_oflag, after.c_oflag);
    EXPECT_EQ(before.c_cflag, after.c_cflag);
    EXPECT_EQ(before.c_lflag, after.c_lflag);
    EXPECT_EQ(std::memcmp(before.c_cc, after.c_cc, sizeof before.c_cc), 0);
}

TEST(SerialPort, TakesStandardAndOtherBitRates) {
    constexpr speed_t kOther = 0x1000;  // BOTHER of asm/termbits.h, which excludes <termios.h>
    struct Row {
        std::uint32_t baud;
        speed_t flag;
    };
    for (const Row& row : {Row{300, B300}, Row{9600, B9600}, Row{19200, B19200}, Row{4'000'000, B4000000},
                           Row{250'000, kOther}}) {
        const Pty pty;
        auto settings = settings_of(pty.path);
        settings.format.baud = row.baud;
        settings.format.parity = wire::Parity::even;  // a pseudo-terminal has none and is not refused for it
        const auto port = SerialPort::open(settings);
        ASSERT_TRUE(port) << row.baud;
        const termios during = settings_now(pty);
        EXPECT_EQ(::cfgetospeed(&during), row.flag) << row.baud;
    }
}

TEST(SerialPort, RefusesWhatIsNoFormat) {
    const Pty pty;
    struct Row {
        wire::CharacterFormat format;
        const char* subject;
    };
    for (const Row& row :
         {Row{{0, 8, wire::Parity::none, 1}, "baud"}, Row{{9600, 9, wire::Parity::none, 1}, "data_bits"},
          Row{{9600, 8, wire::Parity::none, 3}, "stop_bits"}}) {
        auto settings = settings_of(pty.path);
        settings.format = row.format;
        const auto port = SerialPort::open(settings);
        ASSERT_FALSE(port) << row.subject;
        EXPECT_EQ(port.error().code, Code::out_of_range);
        EXPECT_EQ(port.error().subject.view(), row.subject);
    }
}

TEST(SerialPort, SaysWhyItCannotBeOpened) {
    const auto missing = SerialPort::open(settings_of("/dev/no-such-port"));
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error(), (Error{Code::cannot_open, "/dev/no-such-port", {ENOENT, 0, 0}}));
    const auto no_port = SerialPort::open(settings_of("/dev/null"));
    ASSERT_FALSE(no_port);
    EXPECT_EQ(no_port.error(), (Error{Code::cannot_open, "/dev/null", {ENOTTY, 0, 0}}));
}

TEST(SerialPort, IsLockedAgainstASecondUser) {
    const Pty pty;
    {
        const auto first = SerialPort::open(settings_of(pty.path));
        ASSERT_TRUE(first);
        const auto second = SerialPort::open(settings_of(pty.path));
        ASSERT_FALSE(second);
        EXPECT_EQ(second.error(), (Error{Code::busy, std::string_view(pty.path), {}}));
        EXPECT_EQ(settings_now(pty).c_lflag & ICANON, 0u) << "the first user's settings stay";
    }
    EXPECT_TRUE(SerialPort::open(settings_of(pty.path)));
}

TEST(SerialPort, DropsWhatWasThereBefore) {
    const Pty pty;
    pty.write("old request\n");
    const auto port = SerialPort::open(settings_of(pty.path));
    ASSERT_TRUE(port);
    std::uint8_t buffer[16];
    EXPECT_EQ((*port)->read(buffer).value(), 0u);
}

TEST(SerialPort, CarriesEveryByte) {
    const auto loop = make_loop();
    const Pty pty;
    const auto port = SerialPort::open(settings_of(pty.path));
    ASSERT_TRUE(port);
    std::string all(256, '\0');
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<char>(i);
    const Bytes bytes(reinterpret_cast<const std::uint8_t*>(all.data()), all.size());
    ASSERT_EQ((*port)->write(bytes).value(), all.size());
    EXPECT_EQ(read_until(*loop, pty, all.size()), all);

    pty.write(all);
    std::string got;
    EXPECT_TRUE(run_until(*loop, [&] {
        std::uint8_t buffer[100];
        got.append(buffer, buffer + (*port)->read(buffer).value());
        return got.size() >= all.size();
    }));
    EXPECT_EQ(got, all);
}

TEST(SerialPort, OpenedForReadingItSendsNothing) {
    const auto loop = make_loop();
    const Pty pty;
    auto settings = settings_of(pty.path);
    settings.read_only = true;
    const auto port = SerialPort::open(settings);
    ASSERT_TRUE(port);
    const std::uint8_t byte = 1;
    EXPECT_EQ((*port)->write({&byte, 1}).error(),
              (Error{Code::connection_lost, std::string_view(pty.path), {EBADF, 0, 0}}));
    pty.write("a\xff");
    std::vector<wire::Character> got;
    const auto read = [&](std::size_t wanted) {
        return run_until(*loop, [&] {
            wire::Character characters[10];
            const auto count = (*port)->read_characters(characters).value();
            got.insert(got.end(), characters, characters + count);
            return got.size() >= wanted;
        });
    };
    EXPECT_TRUE(read(2));
    ASSERT_TRUE((*port)->set_format({9600, 8, wire::Parity::even, 1}));
    EXPECT_EQ(::cfgetospeed(std::array{settings_now(pty)}.data()), static_cast<speed_t>(B9600));
    pty.write("b");
    EXPECT_TRUE(read(3));
    EXPECT_EQ(got, (std::vector<wire::Character>{{'a', false}, {0xFF, false}, {'b', false}}));
    EXPECT_EQ((*port)->set_format({9600, 9, wire::Parity::even, 1}).error().code, Code::out_of_range);
}

TEST(SerialPort, KnowsPseudoTerminals) {
    const Pty pty;
    EXPECT_TRUE(is_pseudo_terminal(pty.path));
    EXPECT_FALSE(is_pseudo_terminal("/dev/null"));
    EXPECT_FALSE(is_pseudo_terminal("/dev/no-such-port"));
}

TEST(ReceiveTrigger, IsAnAttributeOfThePort) {
    const takt::test::Folder tty;
    tty.write("ttyS1/rx_trig_bytes", "8\n");
    const ReceiveTrigger trigger("/dev/ttyS1", tty.path());
    EXPECT_EQ(trigger.characters(), 8U);
    EXPECT_TRUE(trigger.is_writable());
    EXPECT_EQ(trigger.set(1), 0);
    EXPECT_EQ(trigger.characters(), 1U);
    const ReceiveTrigger none("/dev/ttyS2", tty.path());
    EXPECT_EQ(none.characters(), std::nullopt);
    EXPECT_EQ(none.set(1), ENOENT);
    EXPECT_FALSE(none.is_writable());
}

TEST(RealLine, FitsTheBusToThePort) {
    const Pty pty;
    model::Line line;
    line.port = pty.path;
    EXPECT_EQ(fit_to_real_line({}, line).echo, bus::Echo::untimed);
    line.port = "/dev/ttyS0";
    EXPECT_EQ(fit_to_real_line({}, line).echo, bus::Echo::automatic);
}

TEST(SerialDriver, PutsAnEngineOnThePort) {
    const auto loop = make_loop();
    const Pty pty;
    ScriptEngine engine;
    engine.reply = [](const std::string& request) { return "re:" + request; };
    std::vector<bool> reported;
    DriverOptions options;
    options.on_link = [&](Instant, bool up, const std::optional<Error>&) { reported.push_back(up); };
    const auto driver = open_serial(*loop, settings_of(pty.path), engine, options);
    ASSERT_TRUE(driver);
    EXPECT_EQ((*driver)->name(), pty.path);
    EXPECT_FALSE(engine.up());
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));
    EXPECT_TRUE((*driver)->up());
    EXPECT_EQ(reported, (std::vector{true}));

    pty.write("hello");
    EXPECT_EQ(read_until(*loop, pty, 8), "re:hello");
    engine.output = {"from ", "outside"};
    (*driver)->poke();
    EXPECT_EQ(read_until(*loop, pty, 12), "from outside");
    EXPECT_EQ((*driver)->counters().bytes_read, 5u);
    EXPECT_EQ((*driver)->counters().bytes_written, 20u);
    EXPECT_EQ((*driver)->counters().links, 1u);
}

TEST(SerialDriver, WakesTheEngineNotBeforeItsTime) {
    const auto loop = make_loop();
    const Pty pty;
    ScriptEngine engine;
    const auto driver = open_serial(*loop, settings_of(pty.path), engine);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));
    for (const Duration pause : {0us, 100us, 1750us, 4010us}) {
        engine.ticks.clear();
        const Instant wanted = now() + pause;
        engine.wakeup = wanted;
        (*driver)->poke();
        ASSERT_TRUE(loop->run_until([&] { return !engine.ticks.empty(); }, kDeadline));
        EXPECT_GE(engine.ticks.front(), wanted);
    }
}

TEST(SerialDriver, ReadsWhatIsThereBeforeItWakesTheEngine) {
    const auto loop = make_loop();
    const Pty pty;
    ScriptEngine engine;
    const auto driver = open_serial(*loop, settings_of(pty.path), engine);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));
    send_while_stopped(*loop, engine, **driver, [&] { pty.write("in time"); });
    EXPECT_EQ(engine.input_at_tick, "in time");
}

TEST(SerialDriver, WritesInPartsAndAsksForNothingMeanwhile) {
    const auto loop = make_loop();
    const Pty pty;
    ScriptEngine engine;
    std::string large;
    for (int i = 0; large.size() < 100'000; ++i) large += std::to_string(i) + ",";
    engine.output = {large, "end"};
    const auto driver = open_serial(*loop, settings_of(pty.path), engine);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));
    EXPECT_EQ(engine.output.size(), 1u) << "the second part waits until the first is gone";
    EXPECT_EQ(read_until(*loop, pty, large.size() + 3), large + "end");
}

TEST(SerialDriver, LooksForAPortThatHungUp) {
    const auto loop = make_loop();
    const takt::test::Folder folder;
    const std::string link = folder / "port";
    auto pty = std::make_unique<Pty>();
    std::filesystem::create_symlink(pty->path, link);

    ScriptEngine engine;
    std::vector<Code> reasons;
    DriverOptions options;
    options.on_link = [&](Instant, bool, const std::optional<Error>& why) {
        if (why) reasons.push_back(why->code);
    };
    auto driver = open_serial(*loop, settings_of(link), engine, options);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));

    std::filesystem::remove(link);  // the number of a closed pseudo-terminal is soon another program's
    pty.reset();
    ASSERT_TRUE(loop->run_until([&] { return reasons.size() == 2; }, kDeadline))
        << "lost, and an attempt in vain";
    EXPECT_EQ(reasons, (std::vector{Code::connection_lost, Code::cannot_open}));
    EXPECT_FALSE((*driver)->up());

    pty = std::make_unique<Pty>();
    std::filesystem::create_symlink(pty->path, link);
    ASSERT_TRUE(loop->run_until([&] { return engine.up(); }, kDeadline));
    pty->write("again");
    EXPECT_TRUE(loop->run_until([&] { return engine.input == "again"; }, kDeadline));
    EXPECT_EQ(engine.links, (std::vector{true, false, true}));
    EXPECT_EQ((*driver)->counters().failed_attempts, 1u);
}

TEST(SerialDriver, WaitsForAPortWhereItIsAskedTo) {
    const auto loop = make_loop();
    ScriptEngine engine;
    EXPECT_EQ(open_serial(*loop, settings_of("/dev/no-such-port"), engine).error().code, Code::cannot_open);
    DriverOptions options;
    options.wait_for_port = true;
    std::optional<Error> reason;
    options.on_link = [&](Instant, bool, const std::optional<Error>& why) { reason = why; };
    const auto driver = open_serial(*loop, settings_of("/dev/no-such-port"), engine, options);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return reason.has_value(); }, kDeadline));
    EXPECT_EQ(reason->code, Code::cannot_open);
    EXPECT_TRUE(engine.links.empty());
}

TEST(OpenLine, ChoosesTheTransport) {
    const auto loop = make_loop();
    const Pty pty;
    ScriptEngine engine;
    const auto serial =
        open_line(*loop, parse_target("rtu://" + pty.path + "?baud=9600").value().as_line(), engine);
    ASSERT_TRUE(serial);
    EXPECT_EQ((*serial)->name(), pty.path);
    const auto tls = open_line(*loop, parse_target("tls://127.0.0.1").value().as_line(), engine);
    ASSERT_FALSE(tls);
    EXPECT_EQ(tls.error(), (Error{Code::cannot_open, "certs/ca.pem", {ENOENT, 0, 0}}));
}

}  // namespace serial_test
}  // namespace takt::line
