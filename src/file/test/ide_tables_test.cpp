// The tables of the IDE, typed as their source prints them (docs/specification.md, section 2).
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "outline.hpp"
#include "tables/cell_words.hpp"
#include "takt/base/utf8.hpp"
#include "takt/file/convert.hpp"
#include "takt/model/findings.hpp"

namespace takt::file {
namespace ide_tables_test {

using Findings = std::vector<std::string>;

constexpr std::string_view kStandard =
    "Имя переменной;Тип переменной;Энергонезависимость;Значение по умолчанию;Использование в проекте;"
    "Комментарий\n"
    "r1;Целочисленн...;☑;1;Да;\n"
    "r2;Целочисленное;☑;0;Да;\n"
    "Var1;Булевское;☐;0;Нет;\n"
    "< не выбрана >;Булевское;☐;0;Нет;\n";
constexpr std::string_view kMaster =
    "Имя переменной;Тип переменной;Функция чтения;Функция записи;Адрес регистра;Адрес бита (ов);Комментарий\n"
    "Variable-1;Булевское;0x01;0x05;0;0;\n"
    "< не выбрана >;Булевское;0x01;0x05;0;1;\n";
constexpr std::string_view kSlave =
    "Имя переменной;Тип переменной;Адрес регистра;Использование в проекте;Комментарий\n"
    "Variable;Целочисленное;513;Да;\n"
    "< не выбрана >;Целочисленное;512;Нет;\n";
constexpr std::string_view kList =
    "Имя переменной;Тип;Адрес регистра;Комментарий\n"
    "Var1;С плавающей запя...;0;\n"
    "Var2;С плавающей запятой;2;\n"
    "Var3;Целочисленное;4;\n"
    "Var4;Булевское;5;\n";

const Surroundings kAround{
    {{"name", "line"}, {"transport", "serial"}, {"port", "/dev/ttyUSB0"}, {"framing", "rtu"}},
    {{"name", "D"}, {"address", "16"}}};

struct Titled {
    std::string title;
    std::string_view table;
};

Loaded project_of(const std::vector<Titled>& tables) {
    std::vector<std::pair<std::string, std::string>> texts;
    std::vector<std::string> titles;
    for (const auto& [title, table] : tables) {
        texts.emplace_back(title + ".csv", table);
        titles.push_back(title);
    }
    auto loaded = project_of_tables(load_tables_text(texts), kAround, titles);
    loaded.document.files[0] = "p.yaml";
    return loaded;
}

TEST(IdeTables, AreOneProject) {
    const auto loaded =
        project_of({{"Стандартные", kStandard}, {"Устройство, 16", kMaster}, {"Слот 2", kSlave}});
    EXPECT_EQ(errors_of(loaded), Findings{});
    EXPECT_EQ(locations_and_codes(loaded), Findings{"3/2:1 csv.area_assumed"});
    EXPECT_EQ(write_project(loaded.document.root),
              "takt: 1\n"
              "lines:\n"
              "  - name: line\n"
              "    transport: serial\n"
              "    port: /dev/ttyUSB0\n"
              "    framing: rtu\n"
              "    devices:\n"
              "      - name: Устройство\n"
              "        address: 16\n"
              "        variables:\n"
              "          - {name: Variable-1, type: bool, read: 0x01, write: 0x05, register: 0, bit: 0}\n"
              "servers:\n"
              "  - name: slave\n"
              "    transport: tcp\n"
              "    listen: \"127.0.0.1\"\n"
              "    units:\n"
              "      - address: 16\n"
              "        banks:\n"
              "          - {area: holding_register, items: [513..513]}\n"
              "        variables:\n"
              "          - {name: Variable, type: int16, register: 513, used: true, area: holding_register}\n"
              "locals:\n"
              "  - {name: r1, type: int16, retain: true, default: 1, used: true}\n"
              "  - {name: r2, type: int16, retain: true, default: 0, used: true}\n"
              "  - {name: Var1, type: bool, retain: false, default: 0, used: false}\n");
}

TEST(IdeTables, LocalsAloneMakeNoLine) {
    const auto loaded = project_of({{"Стандартные", kStandard}});
    EXPECT_EQ(errors_of(loaded), Findings{});
    EXPECT_EQ(write_project(loaded.document.root),
              "takt: 1\n"
              "lines: []\n"
              "locals:\n"
              "  - {name: r1, type: int16, retain: true, default: 1, used: true}\n"
              "  - {name: r2, type: int16, retain: true, default: 0, used: true}\n"
              "  - {name: Var1, type: bool, retain: false, default: 0, used: false}\n");
}

TEST(IdeTables, TheShortListIsADevice) {
    const auto loaded = project_of({{"Список", kList}, {"Устройство, 7", kMaster}});
    EXPECT_EQ(errors_of(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    const auto& devices = checked.project.lines.at(0).devices;
    ASSERT_EQ(devices.size(), 2U);
    EXPECT_EQ(devices[0].name, "Список");
    EXPECT_EQ(devices[1].address, UnitId{7});
    const auto& variables = devices[0].variables;
    ASSERT_EQ(variables.size(), 4U);
    EXPECT_EQ(variables[0].type, DataType::float32);
    EXPECT_EQ(variables[1].read, wire::Function::read_holding_registers);
    EXPECT_EQ(variables[2].register_number, 4);
    EXPECT_EQ(variables[3].read, wire::Function::read_coils);
}

TEST(IdeTables, NewDevicesHaveOneName) {
    const std::string window = "Имя;Устройство\nАдрес;";
    const std::string list = "\n\nИмя;Тип;Адрес регистра\nTemperature;Целочисленное;1\n\n";
    const auto windows = window + "16" + list + window + "17" + list;
    const auto loaded = project_of({{"Устройства", windows}});
    EXPECT_EQ(errors_of(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    const auto& devices = checked.project.lines.at(0).devices;
    ASSERT_EQ(devices.size(), 2U);
    EXPECT_EQ(devices[0].variables.at(0).name, "Устройство 16.Temperature");
    EXPECT_EQ(devices[1].variables.at(0).name, "Устройство 17.Temperature");
}

TEST(IdeTables, MayStandInAProject) {
    const std::string project =
        "takt: 1\nlocals: standard.csv\nlines: [{name: L, port: /dev/ttyS0, devices: [{name: D, address: 1, "
        "variables: master.csv}, {name: E, address: 2, variables: list.csv}]}]\n"
        "servers: [{name: S, listen: 127.0.0.1, units: [{address: 1, banks: [{area: holding_register, items: "
        "[0..999]}], variables: slave.csv}]}]\n";
    const auto read = [](const std::string& path) -> Result<std::string> {
        if (path == "standard.csv") return std::string(kStandard).replace(kStandard.find("Var1"), 4, "Loc1");
        if (path == "master.csv") return std::string(kMaster);
        if (path == "slave.csv") return std::string(kSlave);
        return std::string(kList);
    };
    const auto loaded = load_text("p.yaml", project, read);
    EXPECT_EQ(errors_of(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    EXPECT_EQ(checked.project.locals.size(), 3U);
    EXPECT_EQ(checked.project.lines[0].devices[0].variables.size(), 1U);
    EXPECT_EQ(checked.project.servers.at(0).units.at(0).variables.at(0).register_number, 513);
    // standard variables in place of a device's variables are locals too
    const auto instead = load_text("p.yaml",
                                   "takt: 1\nlines: [{name: L, port: /dev/ttyS0, devices: [{name: D, "
                                   "address: 1, variables: standard.csv}]}]\n",
                                   read);
    EXPECT_EQ(errors_of(instead), Findings{});
    EXPECT_EQ(model::interpret(instead.document).project.locals.size(), 3U);
}

TEST(IdeTables, ThePlaceholderIsNone) {
    for (const auto* const text :
         {"< не выбрана >", "<не выбрана>", "‹ не выбрана >", "‹ не выбрана ›", "«не выбрана»",
          "« не выбрана »", "<< не выбрана >>", "( не выбрана )", "[не выбрана]", "< не выбр...",
          "< не выбр… >", "‹ не выбран…", "« не...", "не выбрана", "< НЕ ВЫБРАНА >", "< не вибрана >",
          "&lt; не выбрана &gt;", "< not selected >"})
        EXPECT_TRUE(is_placeholder(text)) << text;
    for (const auto* const text :
         {"", "<", "< не", "не", "< давление >", "не...", "<...>", "нет", "не выбрана 2"})
        EXPECT_FALSE(is_placeholder(text)) << text;
    const auto loaded = load_table_text(
        "t.csv",
        "Имя;Тип;Регистр;Бит;Функция чтения;Функция записи;Запись по изменению;Запуск чтения;Запуск "
        "записи;Статус;"
        "Период, мс;Значение по умолчанию\n"
        "Var1;С плавающей запятой;0;0;0x03;Нет;☒;< не выбрана >;‹ не выбрана ›;«не выбрана»;< не выбр...;<не "
        "выбрана>\n"
        "‹ не выбр…;Булевское;0;1;0x01;0x05;☐;;;;;\n");
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
    ASSERT_EQ(loaded.document.root.items.size(), 1U);
    std::string keys;
    for (const auto& [key, cell] : loaded.document.root.items[0].entries)
        keys += key.text + "=" + cell.text + " ";
    EXPECT_EQ(keys, "name=Var1 type=float register=0 read=0x03 write=none write_on_change=true ");
}

TEST(IdeTables, HeadingsMayBeCut) {
    const auto loaded = load_table_text(
        "t.csv",
        "Имя перем...;Тип пер…;Функция чт...;Адрес регис...;Использование в про...\nA;Булевское;0x01;1;Да\n");
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
    ASSERT_EQ(loaded.document.root.items.size(), 1U);
    EXPECT_EQ(loaded.document.root.items[0].entries.size(), 5U);
    EXPECT_FALSE(locations_and_codes(load_table_text("t.csv", "name,type,Адрес...\nA,int,1\n")).empty());
}

TEST(IdeTables, AnUnknownColumnBecomesAComment) {
    constexpr std::string_view kTable =
        "name,type,reed,register,Цвет,Комментарий,Ряд\nA,int,3,0,red,hot,1\nB,int,3,1,,,\nC,int,3,2,< не "
        "выбрана "
        ">,,5\n";
    const auto loaded = load_table_text("t.csv", std::string(kTable));
    EXPECT_EQ(locations_and_codes(loaded),
              (Findings{"1/1:11 csv.column_taken_as", "1/1:25 csv.column_as_comment",
                        "1/1:42 csv.column_as_comment"}));
    for (const auto& finding : loaded.findings) EXPECT_EQ(finding.severity, model::Severity::warning);
    const auto comment = [&](std::size_t row) {
        const auto* const cell = loaded.document.root.items.at(row).find("comment");
        return cell == nullptr ? std::string() : cell->text;
    };
    EXPECT_EQ(comment(0), "hot; Цвет: red; Ряд: 1");
    EXPECT_EQ(comment(1), "");
    EXPECT_EQ(comment(2), "Ряд: 5");
    const auto strict = load_table_text("t.csv", std::string(kTable), {.strict = true});
    EXPECT_EQ(locations_and_codes(strict).size(), 3U);
    EXPECT_EQ(strict.findings[1].severity, model::Severity::error);
    // a comment has its limit
    const auto lengthy = load_table_text("t.csv", "name,type,Цвет\nA,int," + std::string(3000, 'x') + "\n");
    EXPECT_EQ(count_characters(lengthy.document.root.items.at(0).find("comment")->text), 1000U);
}

TEST(IdeTables, AreWrittenInTheSameWords) {
    const auto written = [](std::string_view table, TableKind kind) {
        const auto tables = load_tables_text({{"t.csv", std::string(table)}});
        EXPECT_EQ(tables.tables.at(0).kind, kind);
        return write_table(tables.tables.at(0).rows.items,
                           {.headings = Headings::ide, .kind = kind, .separator = ';'})
            .bytes;
    };
    const auto as_typed = [](std::string_view table) {
        std::string text;
        for (std::size_t at = 0; at < table.size();) {
            const auto end = table.find('\n', at);
            const auto row = table.substr(at, end - at);
            at = end + 1;
            if (!row.starts_with('<')) text += std::string(row) + "\r\n";
        }
        for (const std::string_view cut : {"Целочисленн...", "С плавающей запя..."})
            if (const auto found = text.find(cut); found != std::string::npos)
                text.replace(found, cut.size(),
                             cut.starts_with("Ц") ? "Целочисленное" : "С плавающей запятой");
        return text;
    };
    EXPECT_EQ(written(kStandard, TableKind::locals), as_typed(kStandard));
    EXPECT_EQ(written(kMaster, TableKind::variables), as_typed(kMaster));
    EXPECT_EQ(written(kSlave, TableKind::served), as_typed(kSlave));
    EXPECT_EQ(written(kList, TableKind::list), as_typed(kList));
}

/// Its tables may have the settings of devices.
Loaded plant_of(const std::vector<Titled>& tables) {
    std::vector<std::pair<std::string, std::string>> texts;
    std::vector<std::string> titles;
    for (const auto& [title, table] : tables) {
        texts.emplace_back(title + ".csv", table);
        titles.push_back(title);
    }
    return project_of_tables(load_tables_text(texts, {.devices = true}), kAround, titles);
}

constexpr std::string_view kWindow =
    "Имя;Устройство\nАдрес;16\nПериод опроса, мс;100\nТаймаут ответа, мс;100\nКол-во попыток;3\n"
    "Протокол;Modbus RTU\n";
constexpr std::string_view kShort = "Имя переменной;Тип переменной;Адрес регистра\nA;Целочисленное;5\n";

TEST(IdeTables, AWindowAsVariablesIsOneError) {
    const std::string project =
        "takt: 1\nlines: [{name: L, port: p, devices: [{name: D, address: 1, variables: w.csv}]}]\n";
    const auto loaded = load_text(
        "p.yaml", project, [](const std::string&) -> Result<std::string> { return std::string(kWindow); });
    ASSERT_EQ(loaded.findings.size(), 1U);
    EXPECT_EQ(loaded.findings[0].code, "file.table_of_devices");
}

TEST(IdeTables, ADeviceWithAnEmptyAddressIsAnError) {
    const auto of = [](std::string_view window) {
        return errors_of(plant_of({{"window", window}, {"list", kShort}}));
    };
    EXPECT_EQ(of(kWindow), Findings{});
    EXPECT_EQ(of("Имя;Устройство\nАдрес;\nПериод опроса, мс;100\n"), Findings{"file.csv.no_address Адрес"});
    EXPECT_EQ(of("Имя;Адрес;Таймаут ответа, мс\nD;;100\n"), Findings{"file.csv.no_address Адрес"});
    EXPECT_EQ(of("Имя;Таймаут ответа, мс\nD;100\n"), Findings{}) << "without a cell the next one is taken";
}

TEST(IdeTables, AnEmptyAddressBelowATreeIsThatOfTheTree) {
    const auto loaded =
        plant_of({{"t", "RS485, Слот 1, Master\nКотёл, 16\nИмя;\nАдрес;\nПериод опроса, мс;100\n" +
                            std::string(kShort)}});
    EXPECT_EQ(errors_of(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    const auto& device = checked.project.lines.at(0).devices.at(0);
    EXPECT_EQ(device.address, UnitId{16});
    EXPECT_EQ(device.name, "Котёл");
}

// Spreadsheets write the value of merged cells in the first row only.
TEST(IdeTables, EachRowOfSeveralDevicesNamesItsDevice) {
    const auto of = [](const std::string& columns, const std::string& rows) {
        const auto loaded = plant_of({{"t", "Имя;Тип;Функция чтения;Регистр;" + columns + "\n" + rows}});
        Findings findings;
        for (const auto& its : loaded.findings)
            if (its.severity == model::Severity::error)
                findings.push_back(its.code + " " + std::to_string(its.location.line) + " " + its.value);
        for (const auto& its : model::interpret(loaded.document).findings)
            if (its.severity == model::Severity::error) findings.push_back(its.code);
        return findings;
    };
    const std::string address = "Адрес устройства";
    EXPECT_EQ(of(address, "A;int;3;1;16\nB;int;3;2;\nC;int;3;3;17\nD;int;3;4;\n"),
              (Findings{"file.csv.no_device 3 Адрес устройства", "file.csv.no_device 5 Адрес устройства"}));
    EXPECT_EQ(of("Прибор;" + address, "A;int;3;1;P;16\nB;int;3;2;;\nC;int;3;3;Q;17\n"),
              Findings{"file.csv.no_device 3 Прибор"});
    EXPECT_EQ(of("Прибор;" + address, "A;int;3;1;P;16\nB;int;3;2;P;\nC;int;3;3;Q;\n"),
              Findings{"file.convert.no_address 4 Q"});
    EXPECT_EQ(of(address, "A;int;3;1;16\nB;int;3;2;\n"), Findings{}) << "one device";
    EXPECT_EQ(of(address, "A;int;3;1;\nB;int;3;2;\n"), Findings{}) << "the default device";
}

// They are settings of a device that the table does not belong to.
TEST(IdeTables, AWindowBelowATableIsNoVariable) {
    const auto of = [](const std::string& text) { return errors_of(plant_of({{"t", text}})); };
    const std::string table(kShort);
    EXPECT_EQ(of(table + std::string(kWindow)), Findings{"file.csv.several_tables Имя"});
    EXPECT_EQ(of(table + "Адрес;16\nПериод опроса, мс;100\n"), Findings{"file.csv.several_tables Адрес"});
    EXPECT_EQ(of(table + "\nТаймаут ответа, мс;100\nКол-во попыток;3\n"),
              Findings{"file.csv.several_tables Таймаут ответа, мс"});
    EXPECT_EQ(of(table + "Период;Целочисленное;6\nСтатус;Целочисленное;7\n"), Findings{}) << "variables";
}

TEST(IdeTables, LinesOfEmptyCellsAreSkipped) {
    const auto devices = [](const std::string& text) {
        const auto loaded = plant_of({{"t", text}});
        EXPECT_EQ(errors_of(loaded), Findings{}) << text;
        std::string names;
        const auto checked = model::interpret(loaded.document);
        for (const auto& device : checked.project.lines.at(0).devices) {
            names += device.name + ':';
            for (const auto& variable : device.variables) names += ' ' + variable.name;
        }
        return names;
    };
    for (const std::string empty :
         {";;\n", ";\n", ",,\n", "\t\t\n", "\u00A0;\u00A0\n", "\"\";\n", " ; ; \n"}) {
        EXPECT_EQ(devices("Имя;Адрес;Таймаут ответа, мс\nD;5;100\n" + empty + empty), "D:") << empty;
        EXPECT_EQ(devices(std::string(kShort) + empty + "B;Целочисленное;6\n" + empty), "t: A B") << empty;
    }
    EXPECT_EQ(devices("name,type,read,register\nA,int16,3,5\n;;\n"), "t: A");
}

TEST(IdeTables, NumbersMayHaveBlanksBetweenTheirDigits) {
    const auto loaded = plant_of({{"t",
                                   "Var;Type;Read;Register;Period, ms;Scale\nA;int16;3;1 000;10 000;0,1\n"
                                   "B;int16;3;1\u00A0001;1\u202F000 ms;1 000,5\n"}});
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
    const auto checked = model::interpret(loaded.document);
    const auto& variables = checked.project.lines.at(0).devices.at(0).variables;
    ASSERT_EQ(variables.size(), 2U);
    EXPECT_EQ(variables[0].name, "A");
    EXPECT_EQ(variables[0].register_number, 1000);
    EXPECT_EQ(variables[1].register_number, 1001);
    EXPECT_EQ(variables[0].period, std::chrono::seconds(10));
    EXPECT_EQ(variables[1].period, std::chrono::seconds(1));
    const auto wrong = plant_of({{"t", "name;type;read;register\nA;int16;3;1 00\n"}});
    EXPECT_FALSE(model::interpret(wrong.document).findings.empty());
}

TEST(IdeTables, DefaultsOfNumbersMayHaveBlanksBetweenTheirDigits) {
    const auto of = [](const std::string& type_and_default) {
        const auto loaded =
            plant_of({{"t", "Имя;Тип;Функция чтения;Регистр;Длина строки;Значение по умолчанию\nA;" +
                                type_and_default}});
        const auto& device = loaded.document.root.find("lines")->items[0].find("devices")->items[0];
        return device.find("variables")->items[0].find("default")->text;
    };
    EXPECT_EQ(of("Целочисленное;3;0;;1 000\n"), "1000");
    EXPECT_EQ(of("int32;3;0;;-1\u00A0000 000\n"), "-1000000");
    EXPECT_EQ(of("С плавающей запятой;3;0;;-1\u2009000\u202F000,5\n"), "-1000000.5");
    EXPECT_EQ(of("string;3;0;8;1 000\n"), "1 000") << "a text is as it was typed";
    EXPECT_EQ(of("Целочисленное;3;0;;1 00\n"), "1 00");
    const auto locals =
        load_table_text("t.csv", "Имя;Тип;Энергонезависимость;По умолчанию\nA;int;Да;1 000\n");
    EXPECT_EQ(locals.document.root.items[0].find("default")->text, "1000");
}

// The column of devices is no reason to ask for functions: without them the list of an IDE has defaults.
TEST(IdeTables, AListOfSeveralDevicesHasTheAreasOfAList) {
    for (const std::string column : {"Адрес устройства", "Unit address", "Адреса пристрою", "Slave ID"}) {
        const auto loaded =
            plant_of({{"t", "Имя;Тип;Регистр;" + column + "\nA;Целочисленное;1;16\nB;Булевское;2;17\n"}});
        EXPECT_EQ(errors_of(loaded), Findings{}) << column;
        EXPECT_EQ(locations_and_codes(loaded), Findings{"1/2:1 csv.area_assumed"}) << column;
        const auto checked = model::interpret(loaded.document);
        const auto& devices = checked.project.lines.at(0).devices;
        ASSERT_EQ(devices.size(), 2U);
        EXPECT_EQ(devices[0].variables.at(0).area, wire::Area::holding_register);
        EXPECT_EQ(devices[1].variables.at(0).area, wire::Area::coil);
    }
}

// A row without functions in a table with one of them has no traffic only beside the other one.
TEST(IdeTables, ARowWithoutAreaIsWrittenAsItWasRead) {
    const auto loaded = load_table_text(
        "t.csv", "name;type;register;area;write\nA;float;0;0x04;\nB;float;1;;\nC;uint16;2;0x03;0x10\n", {});
    EXPECT_EQ(locations_and_codes(loaded), Findings{});
    const auto written = write_table(loaded.document.root.items, {});
    const auto again = load_table_text("again.csv", written.bytes, {});
    ASSERT_EQ(again.document.root.items.size(), 3U);
    EXPECT_EQ(again.document.root.items[1].find("area"), nullptr);
}

}  // namespace ide_tables_test
}  // namespace takt::file
