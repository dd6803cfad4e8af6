/* Options of lwIP for tcp_device.cpp: no operating system, IPv4 with TCP and ping, memory of fixed size. */
#pragma once

/* Connections that are served at once, and bytes that each may receive before they are processed. */
#define TAKT_TCP_CONNECTIONS 4
#define TAKT_TCP_WINDOW 1072

#define NO_SYS 1
#define SYS_LIGHTWEIGHT_PROT 0
#define LWIP_SOCKET 0
#define LWIP_NETCONN 0
#define LWIP_RAW 0
#define LWIP_UDP 0
#define LWIP_DHCP 0
#define LWIP_DNS 0
#define LWIP_TCP 1
#define LWIP_ICMP 1
#define IP_REASSEMBLY 0
#define IP_FRAG 0
#define ARP_QUEUEING 0
#define ARP_TABLE_SIZE 8
#define LWIP_NETIF_TX_SINGLE_PBUF 1

/* A frame is processed before the next one is taken from the controller: the pool holds the longest one. */
#define MEM_ALIGNMENT 4
#define MEM_SIZE (12 * 1024)
#define PBUF_POOL_SIZE 4
#define PBUF_POOL_BUFSIZE 512
#define MEMP_NUM_PBUF 4

/* Segments out of order are dropped, and sent again by the peer: no peer can hold buffers with them. Besides
   the served connections: as many in the handshake, and as many that are being closed. */
#define TCP_QUEUE_OOSEQ 0
#define TCP_MSS 536
#define TCP_WND TAKT_TCP_WINDOW
#define TCP_SND_BUF (2 * TCP_MSS)
#define TCP_SND_QUEUELEN 8
#define MEMP_NUM_TCP_PCB (3 * TAKT_TCP_CONNECTIONS)
#define MEMP_NUM_TCP_PCB_LISTEN 1
#define MEMP_NUM_TCP_SEG 32
#define TCP_LISTEN_BACKLOG 1
#define TCP_DEFAULT_LISTEN_BACKLOG TAKT_TCP_CONNECTIONS
#define TCP_MAXRTX 6
#define TCP_SYNMAXRTX 3
#define LWIP_TCP_RTO_TIME 1000
#define LWIP_TCP_KEEPALIVE 1

#define LWIP_STATS 1
#define LWIP_STATS_LARGE 0
#define LINK_STATS 0
#define ETHARP_STATS 0
#define IP_STATS 0
#define ICMP_STATS 0
#define TCP_STATS 0
#define MEM_STATS 1
#define MEMP_STATS 1
