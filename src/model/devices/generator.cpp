// Values that move by themselves.
#include "devices/binding.hpp"

namespace takt::model {
namespace {

/// A generator moves within `from`..`to`; `rising`: only upwards.
Generator read_range(Reader& reader, Generator::Motion motion, bool rising) {
    Generator generator{.motion = motion};
    generator.from = reader.number("from").value_or(0);
    generator.to = reader.number("to").value_or(generator.from + 1);
    if (rising && generator.to <= generator.from)
        reader.report(Rule::field_out_of_range, "to", "> " + to_text(generator.from));
    return generator;
}

void read_steps(Reader& reader, Generator& generator) {
    generator.step = reader.number("step").value_or(1);
    if (generator.step <= 0) {
        reader.report(Rule::field_out_of_range, "step", "> 0");
        generator.step = 1;
    }
    generator.period = reader.duration("every").value_or(generator.period);
}

}  // namespace

Generator read_generator(Interpretation& state, Reader& outer, std::string_view key, const Node& node) {
    using Motion = Generator::Motion;
    if (key == "sine") {
        auto reader = inner(state, outer, key, node, Object::sine);
        Generator sine;
        const double amplitude = reader.number("amplitude").value_or(1);
        const double offset = reader.number("offset").value_or(0);
        sine.from = offset - amplitude;
        sine.to = offset + amplitude;
        sine.period = reader.duration("period").value_or(sine.period);
        return sine;
    }
    if (key == "ramp") {
        auto reader = inner(state, outer, key, node, Object::ramp);
        auto ramp = read_range(reader, Motion::ramp, false);
        ramp.period = reader.duration("period").value_or(ramp.period);
        return ramp;
    }
    const bool walk = key == "random_walk";
    auto reader = inner(state, outer, key, node, walk ? Object::random_walk : Object::counter);
    auto generator = read_range(reader, walk ? Motion::random_walk : Motion::counter, true);
    read_steps(reader, generator);
    if (walk) generator.seed = static_cast<std::uint64_t>(reader.integer("seed").value_or(1));
    return generator;
}

}  // namespace takt::model
