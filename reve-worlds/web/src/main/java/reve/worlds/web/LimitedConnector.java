// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.io.ManagedSelector;
import org.eclipse.jetty.io.SelectorManager;
import org.eclipse.jetty.io.SocketChannelEndPoint;
import org.eclipse.jetty.server.ConnectionFactory;
import org.eclipse.jetty.server.Server;
import org.eclipse.jetty.server.ServerConnector;
import org.eclipse.jetty.util.thread.Scheduler;

import java.io.IOException;
import java.nio.channels.SelectableChannel;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;
import java.util.concurrent.Executor;

/**
 * A connector that enforces limits. It closes connections beyond the limits of {@link Visitors} at
 * once, and reads the other connections within their {@link ReadBudget}.
 */
final class LimitedConnector extends ServerConnector {

    private final Visitors visitors;

    LimitedConnector(Server server, Visitors visitors, ConnectionFactory[] factories) {
        super(server, null, null, null, 1, 1, factories);
        this.visitors = visitors;
    }

    @Override
    protected SelectorManager newSelectorManager(
            Executor executor, Scheduler scheduler, int selectors) {
        return new ServerConnectorManager(executor, scheduler, selectors) {
            @Override
            public void accept(SelectableChannel channel, Object attachment) {
                if (mayStay((SocketChannel) channel)) {
                    super.accept(channel, attachment);
                }
            }
        };
    }

    @Override
    protected SocketChannelEndPoint newEndPoint(
            SocketChannel channel, ManagedSelector selector, SelectionKey key) {
        var budget = new ReadBudget(() -> getConnectedEndPoints().size(), System::nanoTime);
        var end = new MeteredEndPoint(channel, selector, key, getScheduler(), budget);
        end.setIdleTimeout(getIdleTimeout());
        return end;
    }

    private boolean mayStay(SocketChannel channel) {
        try {
            if (visitors.admit(channel)) {
                return true;
            }
        } catch (IOException closed) {
            // The exception is ignored, because the client has already closed the connection.
        }
        try {
            channel.close();
        } catch (IOException e) {
            // The exception is ignored, because the operating system frees the file descriptor even
            // if close() fails.
        }
        return false;
    }
}
