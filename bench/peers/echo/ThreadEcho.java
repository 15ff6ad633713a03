// SPDX-License-Identifier: Apache-2.0
import java.io.IOException;
import java.io.InputStream;
import java.io.OutputStream;
import java.net.InetSocketAddress;
import java.net.ServerSocket;
import java.net.Socket;

/** An echo server with a virtual thread per connection, which uses blocking reads and writes. */
final class ThreadEcho {

    public static void main(String[] arguments) throws IOException {
        try (var listening = new ServerSocket()) {
            int port = Integer.parseInt(arguments[0]);
            listening.bind(new InetSocketAddress("127.0.0.1", port), 2048);
            while (true) {
                Socket client = listening.accept();
                client.setTcpNoDelay(true);
                Thread.startVirtualThread(() -> echo(client));
            }
        }
    }

    private static void echo(Socket client) {
        try (client) {
            InputStream in = client.getInputStream();
            OutputStream out = client.getOutputStream();
            byte[] bytes = new byte[65536];
            for (int count = in.read(bytes); count > 0; count = in.read(bytes)) {
                out.write(bytes, 0, count);
            }
        } catch (IOException e) {
            // The exception is ignored. It means that the client has disconnected.
        }
    }
}
