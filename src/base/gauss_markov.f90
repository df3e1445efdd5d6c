!> Stationary Gauss-Markov processes at equidistant epochs: what a filter needs to follow a disturbance
!> that is not known but whose size and correlation time are.
!>
!>     p(k+1) = Phi p(k) + L n(k),   n(k) white with unit covariance,   output = h^T p(k)
!>
!> First order: exponentially correlated, autocovariance sigma^2 exp(-|t|/tau) (A. Gelb (ed.), Applied
!> Optimal Estimation (1974) section 3.8). Second order: the damped oscillator
!> x'' + 2 zeta omega x' + omega^2 x = white noise (ibid.), whose spectrum falls with f^-4; with
!> zeta = 1 a smooth wander, with a small zeta an oscillation whose amplitude and phase wander with
!> the time 1/(zeta omega).
module gracecg_base_gauss_markov
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: gauss_markov_t, first_order_process, second_order_process, no_process, superposed

    !> A stationary process in discrete time, with a scalar output.
    type :: gauss_markov_t
        integer :: n = 0                                    !! Number of states
        real(dp), allocatable :: transition(:, :)           !! Phi over one interval, n x n
        real(dp), allocatable :: noise_root(:, :)           !! L, lower triangle; L L^T = Q
        real(dp), allocatable :: noise(:, :)                !! Q
        real(dp), allocatable :: covariance(:, :)           !! At the start: the stationary one
        real(dp), allocatable :: output(:)                  !! h
    end type gauss_markov_t

    !> Nodes and weights of Gauss and Legendre's quadrature with five points on (-1, 1): M. Abramowitz,
    !> I. A. Stegun, Handbook of Mathematical Functions (1964) table 25.4
    real(dp), parameter :: NODE(5) = [-0.906179845938664_dp, -0.538469310105683_dp, 0.0_dp, &
                                      0.538469310105683_dp, 0.906179845938664_dp]
    real(dp), parameter :: WEIGHT(5) = [0.236926885056189_dp, 0.478628670499366_dp, 0.568888888888889_dp, &
                                        0.478628670499366_dp, 0.236926885056189_dp]

contains

    !> A process without states.
    pure function no_process() result(process)
        type(gauss_markov_t) :: process

        process = empty_process(0)
    end function no_process

    pure function empty_process(n) result(process)
        integer, intent(in) :: n
        type(gauss_markov_t) :: process

        process%n = n
        allocate (process%transition(n, n), process%noise_root(n, n), process%noise(n, n), process%covariance(n, n), source=0.0_dp)
        allocate (process%output(n), source=0.0_dp)
    end function empty_process

    !> Exponentially correlated noise.
    pure function first_order_process(sigma, phi) result(process)
        real(dp), intent(in) :: sigma       !! Standard deviation of the output, its unit
        real(dp), intent(in) :: phi         !! Correlation over one interval, exp(-interval/tau), 0 < phi < 1
        type(gauss_markov_t) :: process

        process = empty_process(1)
        process%transition = phi
        process%noise_root = sigma*sqrt((1 - phi)*(1 + phi))
        process%noise = process%noise_root**2
        process%covariance = sigma**2
        process%output = 1
    end function first_order_process

    !> Damped oscillator, in the states x and x'/omega: both have the standard deviation sigma.
    !>
    !> The noise covariance Q = 4 zeta sigma^2 integral of (Phi(s) b)(Phi(s) b)^T ds, b = (0, 1), is
    !> integrated rather than taken as the difference of two nearly equal matrices.
    pure function second_order_process(sigma, omega, zeta, interval) result(process)
        real(dp), intent(in) :: sigma       !! Standard deviation of the output, its unit
        real(dp), intent(in) :: omega       !! Undamped angular frequency, rad/s, > 0
        real(dp), intent(in) :: zeta        !! Damping ratio, 0 < zeta <= 1
        real(dp), intent(in) :: interval    !! Between epochs, s
        type(gauss_markov_t) :: process

        real(dp) :: q(2, 2), tau, step, forced(2, 2)
        integer :: pieces, i, j

        tau = omega*interval
        pieces = max(1, ceiling(4*tau))         ! a quarter of a radian: exact to rounding
        step = tau/pieces
        q = 0
        do i = 1, pieces
            do j = 1, size(NODE)
                forced = oscillator_transition((i - 0.5_dp)*step + NODE(j)*step/2, zeta)
                q = q + WEIGHT(j)*step/2*spread(forced(:, 2), 2, 2)*spread(forced(:, 2), 1, 2)
            end do
        end do
        q = 4*zeta*sigma**2*q
        process = empty_process(2)
        process%transition = oscillator_transition(tau, zeta)
        process%noise_root(1, 1) = sqrt(q(1, 1))
        if (q(1, 1) > 0) process%noise_root(2, 1) = q(2, 1)/process%noise_root(1, 1)
        process%noise_root(2, 2) = sqrt(max(0.0_dp, q(2, 2) - process%noise_root(2, 1)**2))
        process%noise = matmul(process%noise_root, transpose(process%noise_root))
        process%covariance(1, 1) = sigma**2
        process%covariance(2, 2) = sigma**2
        process%output(1) = 1
    end function second_order_process

    !> Transition matrix of (x, x'/omega) over the phase tau = omega t.
    pure function oscillator_transition(tau, zeta) result(phi)
        real(dp), intent(in) :: tau         !! rad
        real(dp), intent(in) :: zeta
        real(dp) :: phi(2, 2)

        real(dp) :: damped, c, s

        damped = sqrt((1 - zeta)*(1 + zeta))
        c = cos(damped*tau)
        if (abs(damped*tau) > 1e-4_dp) then
            s = sin(damped*tau)/damped
        else
            s = tau*(1 - (damped*tau)**2/6)
        end if
        phi(1, :) = exp(-zeta*tau)*[c + zeta*s, s]
        phi(2, :) = exp(-zeta*tau)*[-s, c - zeta*s]
    end function oscillator_transition

    !> The sum of two independent processes.
    pure function superposed(a, b) result(process)
        type(gauss_markov_t), intent(in) :: a, b
        type(gauss_markov_t) :: process

        integer :: n

        n = a%n
        process = empty_process(a%n + b%n)
        process%transition(:n, :n) = a%transition
        process%transition(n + 1:, n + 1:) = b%transition
        process%noise_root(:n, :n) = a%noise_root
        process%noise_root(n + 1:, n + 1:) = b%noise_root
        process%noise(:n, :n) = a%noise
        process%noise(n + 1:, n + 1:) = b%noise
        process%covariance(:n, :n) = a%covariance
        process%covariance(n + 1:, n + 1:) = b%covariance
        process%output(:n) = a%output
        process%output(n + 1:) = b%output
    end function superposed
end module gracecg_base_gauss_markov
