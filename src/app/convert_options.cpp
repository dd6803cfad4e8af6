// convert.
#include "command_line.hpp"

namespace takt::app {
namespace {

const std::map<std::string, FileKind> kFileKinds{{"csv", FileKind::csv}, {"yaml", FileKind::yaml}};
const std::map<std::string, char> kSeparators{
    {"comma", ','}, {"semicolon", ';'}, {"tab", '\t'}, {",", ','}, {";", ';'}};
const std::map<std::string, file::Addresses> kAddresses{{"zero-based", file::Addresses::zero_based},
                                                        {"reference", file::Addresses::reference},
                                                        {"auto", file::Addresses::automatic}};
const std::map<std::string, file::Headings> kHeadings{{"keys", file::Headings::keys},
                                                      {"en", file::Headings::english},
                                                      {"ru", file::Headings::russian},
                                                      {"uk", file::Headings::ukrainian}};

void add_encoding(CLI::App& command, const std::string& name, std::optional<file::Encoding>& encoding,
                  bool* byte_order_mark, const std::string& help) {
    command
        .add_option_function<std::string>(
            name,
            [&encoding, byte_order_mark](const std::string& text) {
                encoding = text == "cp1251" ? file::Encoding::cp1251 : file::Encoding::utf8;
                if (byte_order_mark != nullptr) *byte_order_mark = text == "utf-8-bom";
            },
            help)
        ->check(CLI::IsMember({"utf-8", "utf-8-bom", "cp1251"}))
        ->type_name("ENCODING");
}

}  // namespace

void add_convert(CLI::App& app, CommandLine& line) {
    auto& options = line.convert;
    auto& convert = add_command(app, line, "convert", "help.convert",
                                [&] { return app::convert(line.common, line.convert); });
    convert.add_option("input", options.input, "help.convert.input")->required()->type_name("IN");
    convert.add_option("-o,--output", options.output, "help.convert.output")->type_name("OUT");
    convert.add_flag("--force", options.force, "help.convert.force");
    add_word(convert, "--from", options.from, kFileKinds, "help.convert.from")->type_name("KIND");
    add_word(convert, "--to", options.to, kFileKinds, "help.convert.to")->type_name("KIND");
    convert.add_option("--line", options.line, "help.convert.line")->capture_default_str();
    convert.add_option("--device", options.device, "help.convert.device");
    convert
        .add_option_function<int>(
            "--unit", [&](int unit) { options.unit = static_cast<std::uint8_t>(unit); }, "help.convert.unit")
        ->check(CLI::Range(0, 255));
    convert.add_option("--target", options.target, "help.convert.target")
        ->type_name("TARGET")
        ->capture_default_str();
    options.reading.addresses = file::Addresses::automatic;
    add_word(convert, "--addresses", options.reading.addresses, kAddresses, "help.convert.addresses")
        ->type_name("NOTATION");
    add_word(convert, "--headings", options.writing.headings, kHeadings, "help.convert.headings")
        ->type_name("HEADINGS");
    add_word(convert, "--separator", options.separator, kSeparators, "help.convert.separator")
        ->type_name("SEPARATOR");
    add_encoding(convert, "--encoding", options.encoding, &options.byte_order_mark, "help.convert.encoding");
    add_word(convert, "--input-separator", options.reading.separator, kSeparators, "help.convert.reading")
        ->type_name("SEPARATOR");
    add_encoding(convert, "--input-encoding", options.reading.encoding, nullptr, "help.convert.reading");
}

}  // namespace takt::app
