// SPDX-License-Identifier: Apache-2.0
package reve.worlds.web;

import org.eclipse.jetty.io.EndPoint;
import org.eclipse.jetty.io.ManagedSelector;
import org.eclipse.jetty.io.SocketChannelEndPoint;
import org.eclipse.jetty.server.Request;
import org.eclipse.jetty.util.thread.Scheduler;

import java.io.IOException;
import java.nio.ByteBuffer;
import java.nio.channels.SelectionKey;
import java.nio.channels.SocketChannel;
import java.util.concurrent.TimeUnit;

/** A connection to the web port that is read within its {@link ReadBudget}. */
final class MeteredEndPoint extends SocketChannelEndPoint {

    private final ReadBudget budget;

    MeteredEndPoint(
            SocketChannel channel,
            ManagedSelector selector,
            SelectionKey key,
            Scheduler scheduler,
            ReadBudget budget) {
        super(channel, selector, key, scheduler);
        this.budget = budget;
    }

    /** Returns the budget of the connection of a request. */
    static ReadBudget budgetOf(Request request) {
        EndPoint end = request.getConnectionMetaData().getConnection().getEndPoint();
        while (end instanceof EndPoint.Wrapper wrapper) {
            // The wrapper is the TLS layer of the connection.
            end = wrapper.unwrap();
        }
        return ((MeteredEndPoint) end).budget;
    }

    @Override
    public int fill(ByteBuffer buffer) throws IOException {
        if (budget.waitNanos() > 0) {
            return 0; // pretends that no data arrived; needsFillInterest() waits
        }
        int count = super.fill(buffer);
        budget.spend(Math.max(0, count));
        return count;
    }

    @Override
    protected void needsFillInterest() {
        long wait = budget.waitNanos();
        if (wait == 0) {
            super.needsFillInterest();
        } else {
            getScheduler().schedule(super::needsFillInterest, wait, TimeUnit.NANOSECONDS);
        }
    }
}
