#include "io/step/occt.h"

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <iostream>

namespace afptraj::step {

QuietOcct::QuietOcct() : cout_(std::cout.rdbuf(nullptr)), cerr_(std::cerr.rdbuf(nullptr)) {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
}

QuietOcct::~QuietOcct() {
  std::cout.rdbuf(cout_);
  std::cerr.rdbuf(cerr_);
}

}  // namespace afptraj::step
