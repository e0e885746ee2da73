/* Reads every topic of the house in one domain and writes what it has understood in the next. Whatever its
 * types cannot hold, it loses. Usage: cyclone_echo DOMAIN, until its standard input ends. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "cyclone_topics.h"

static int input_has_ended(void) {
  struct pollfd input = {STDIN_FILENO, POLLIN, 0};
  char byte;
  return poll(&input, 1, 1) > 0 && read(STDIN_FILENO, &byte, 1) <= 0;
}

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  const dds_domainid_t domain = (dds_domainid_t)strtoul(argv[1], NULL, 10);
  const dds_entity_t here = participant_of(domain);
  const dds_entity_t there = participant_of(domain + 1);
  dds_entity_t* readers = calloc(topic_count, sizeof *readers);
  dds_entity_t* writers = calloc(topic_count, sizeof *writers);
  for (size_t i = 0; i < topic_count; ++i) {
    readers[i] = reader_of(here, &every_topic[i]);
    writers[i] = writer_of(there, &every_topic[i]);
  }
  while (!input_has_ended()) {
    for (size_t i = 0; i < topic_count; ++i) {
      refuse_incompatible_reader(readers[i], every_topic[i].name);
      refuse_incompatible_writer(writers[i], every_topic[i].name);
      void* sample = NULL;
      dds_sample_info_t info;
      while (dds_take(readers[i], &sample, &info, 1, 1) == 1) {
        if (info.valid_data) checked(dds_write(writers[i], sample), every_topic[i].name);
        dds_return_loan(readers[i], &sample, 1);
        sample = NULL;
      }
    }
  }
  free(readers);
  free(writers);
  dds_delete(here);
  dds_delete(there);
  return 0;
}
