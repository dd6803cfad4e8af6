#!/bin/sh
# Certificates of a test, made by OpenSSL's command line in the folder $1: a folder for each client, with the
# names that `?certs=FOLDER` expects, and the server's own in `server`.
set -e
cd "$1"
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 30 -subj "/CN=Plant root" \
  -keyout root.key -out root.pem -addext keyUsage=critical,keyCertSign,cRLSign 2>/dev/null
leaf() {  # FOLDER NAME EXTENSIONS [DAYS]
  mkdir -p "$1"
  openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj "/CN=$1" -keyout "$1/$2.key" \
    -out csr 2>/dev/null
  printf 'basicConstraints=critical,CA:FALSE\nkeyUsage=critical,digitalSignature\n%b\n' "$3" > extensions
  openssl x509 -req -in csr -CA root.pem -CAkey root.key -CAcreateserial -days "${4:-30}" \
    -extfile extensions -out "$1/$2.pem" 2>/dev/null
  cp root.pem "$1/ca.pem"
}
role=1.3.6.1.4.1.50316.802.1
client=extendedKeyUsage=clientAuth
leaf server server 'extendedKeyUsage=serverAuth\nsubjectAltName=DNS:localhost,IP:127.0.0.1'
leaf operator client "$client\n$role=ASN1:UTF8String:Operator"
leaf norole client "$client"
leaf wrongtype client "$client\n$role=ASN1:PRINTABLESTRING:Operator"
leaf nul client "$client\n$role=DER:0c:09:4f:70:65:72:00:61:74:6f:72"
leaf broken client "$client\n$role=DER:0c:20:41"
leaf serverasclient client "extendedKeyUsage=serverAuth\n$role=ASN1:UTF8String:Operator"
leaf expired client "$client\n$role=ASN1:UTF8String:Operator" 0
leaf revoked client "$client\n$role=ASN1:UTF8String:Operator"
{
  printf '[ca]\ndefault_ca=c\n[c]\ndatabase=index\ncrlnumber=number\ndefault_md=sha256\n'
  printf 'default_crl_days=30\ncertificate=root.pem\nprivate_key=root.key\n'
} > ca.cnf
: > index
echo 01 > number
openssl ca -config ca.cnf -revoke revoked/client.pem 2>/dev/null
openssl ca -config ca.cnf -gencrl -out root.crl 2>/dev/null
mkdir -p stranger
openssl req -x509 -newkey rsa:2048 -nodes -days 30 -subj "/CN=stranger" -keyout stranger/client.key \
  -out stranger/client.pem -addext "$client" -addext "$role=ASN1:UTF8String:Operator" 2>/dev/null
cp root.pem stranger/ca.pem
