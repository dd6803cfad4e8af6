// The three descriptors that every program inherits.
#pragma once

namespace takt::os {

/// Opens /dev/null at each of the descriptors 0, 1 and 2 that is closed. Otherwise the next file or socket
/// that is opened would get the number, and text for stdout or stderr would be written into it. To be called
/// before anything else is opened.
void open_standard_streams();

}  // namespace takt::os
