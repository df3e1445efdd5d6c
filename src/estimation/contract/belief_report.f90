!> What the tests of the operator's beliefs have found, for whoever shows it.
module gracecg_estimation_belief_report
    use gracecg_base_kinds, only: dp
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_observations_parameters, only: FIELD_BIAS, MOUNTING_1, MOUNTING_2, belief_subject, IS_OF_FIELD
    implicit none
    private
    public :: belief_report_t, value_test_t, noise_test_t, explanation_t, OF_VALUE, OF_ALTERATION, OF_NOISE
    public :: begin_report, add_value, add_noise, add_score, finish_report
    public :: CONFIRMED, UNTESTED, CONTRADICTED, FAMILY_LEVEL, POWER, NOISE_SUBJECTS, SAME
    public :: OF_STAR_CAMERA, LINES, FIELD_AGAINST_MODEL, HEADS_APART

    integer, parameter :: CONFIRMED = 1     !! A wrong value that matters would have been seen
    integer, parameter :: UNTESTED = 2
    !! It cannot be tested here: a value that no test sees, within what the operator states, could move the offset by more
    !! than is wanted
    integer, parameter :: CONTRADICTED = 3  !! By the data
    real(dp), parameter :: FAMILY_LEVEL = 1e-3_dp   !! Probability that right beliefs are contradicted anywhere
    real(dp), parameter :: SUSPICIOUS = 3.3_dp
    !! Score beyond which what the operator states of a value limits nothing: a sound one has it with the probability 1e-3.
    !! Of the magnetometer and the star-camera heads also the score of what the fit does not look at
    real(dp), parameter :: NOISE_KNOWN = 0.03_dp
    !! To which standard deviations of noise are known to anybody, relative, chosen: setups whose variances are 20 % too small are
    !! taken (28 of 30; 9 of 10 were refused; sigmas grow by what is seen), and scale factors wrong by 20 % still contradict
    !! the noise
    real(dp), parameter :: POWER = 0.8_dp   !! With which a minimal detectable value is found

    !> Subjects of the noise tests: levels, correlation of neighbouring residuals, lines in their spectra, and
    !> whether magnetometer, orbit and attitude belong together
    character(32), parameter :: NOISE_SUBJECTS(14) = [character(32) :: &
        'noise of accelerometer x', 'noise of accelerometer y', 'noise of accelerometer z', &
        'noise of star camera about x', 'noise of star camera about y', 'noise of star camera boresight', &
        'colour of accelerometer x noise', 'colour of accelerometer y noise', 'colour of accelerometer z noise', &
        'line in accelerometer x', 'line in accelerometer y', 'line in accelerometer z', &
        'magnetometer against field model', 'star-camera heads, each other']

    !> Places of some
    integer, parameter :: OF_STAR_CAMERA(3) = [4, 5, 6], LINES(3) = [10, 11, 12], FIELD_AGAINST_MODEL = 13, HEADS_APART = 14

    !> The test of a belief with a value.
    type :: value_test_t
        integer :: belief = 0               !! The parameter's place
        character(48) :: subject = ''       !! What it is of, in words
        real(dp) :: value = 0               !! That fits the data best, SI units
        real(dp) :: sigma = 0               !! Its standard deviation by the data; 0: they do not determine it
        real(dp) :: score = 0               !! T: standard normal if the belief is right, and all others are exact
        real(dp) :: fair = 0                !! The same if every belief is right to what is stated of it
        real(dp) :: detectable = 0          !! Minimal detectable value, SI units; 0: none
        real(dp) :: largest = 0             !! Wrong value that is conceivable, SI units
        real(dp) :: stated = 0              !! The same within three standard deviations of what the operator states
        real(dp) :: unseen = 0              !! Wrong value that no test sees, SI units: the smaller of `detectable` and `largest`
        logical :: all_or_nothing = .false. !! It is either 0 or `largest`
        real(dp) :: effect(3) = 0
        !! What `unseen` does to the offset, m
        real(dp) :: within(3) = 0
        !! The same of the smaller of `unseen` and `stated`; where the score is suspicious, of the value found, too, m
        real(dp) :: shift(3) = 0            !! What the value found adds to the offset estimated without it, m
        integer :: state = CONFIRMED        !! One of the three
    end type value_test_t

    !> The test of a noise level.
    type :: noise_test_t
        integer :: subject = 0              !! Its place in NOISE_SUBJECTS
        real(dp) :: factor = 1              !! Standard deviation found by that believed
        real(dp) :: score = 0               !! Standard normal if the belief is right, a level to NOISE_KNOWN
        real(dp) :: significance = 0        !! The same of a level that is right exactly
        real(dp) :: gain = 0                !! Of the log-likelihood, if the level were that found
        real(dp) :: frequency = 0           !! Of a line, Hz
        logical :: at_a_rod = .false.       !! The line has the frequency of a rod, as far as the arc tells them apart
        integer :: state = CONFIRMED        !! CONFIRMED or CONTRADICTED
    end type noise_test_t

    integer, parameter :: OF_VALUE = 1, OF_ALTERATION = 2, OF_NOISE = 3     !! Kinds of explanations
    real(dp), parameter :: SAME = 7         !! Of log-likelihoods of explanations: one is a thousand times as likely as the other

    !> A wrong belief that would explain the data.
    type :: explanation_t
        integer :: kind = 0                 !! OF_VALUE, OF_ALTERATION, OF_NOISE
        integer :: place = 0                !! A parameter, or in ALTERATIONS, NOISE_SUBJECTS
        real(dp) :: gain = 0                !! Of the log-likelihood of the data
        real(dp) :: value = 0               !! SI units; of a noise the factor of its standard deviation
        real(dp) :: sigma = 0               !! Of the value
        real(dp) :: offset(3) = 0           !! With it, m
        logical :: complete = .false.       !! With it no belief is contradicted
    end type explanation_t

    !> All tests of one fit.
    type :: belief_report_t
        real(dp) :: offset(3) = 0           !! Estimated, m
        real(dp) :: wanted = 5e-5_dp        !! Accuracy of each component, m
        real(dp) :: apart(3) = 0
        !! What the estimate differs from that of `optimal` by, m: what its sigmas leave out
        real(dp) :: stated(3) = 0
        !! Standard deviation of the estimate by what is stated of all beliefs that are not estimated, m
        logical :: signs_known = .false.    !! Of the accelerometer's axes together: no calibration alone tells
        real(dp) :: critical = 0            !! Of a score
        real(dp) :: wave_frequency = 0      !! Of the density wave that the fit found, Hz; 0: none
        real(dp) :: field_seen(3) = 0, field_modelled(3) = 0    !! Of the magnetometer and the model, means in body axes, T
        real(dp) :: arc = 0                 !! Its length, s; 0: not told
        logical :: feels_air = .false.      !! The accelerometer is quieter than the model of the air's forces is good
        character(112) :: lost_channel = ''  !! Of a rod that the setup drives and that was measured to do nothing, in words
        real(dp) :: head_turn(3) = 0        !! From star-camera head 1 to head 2, body axes, rad
        type(value_test_t), allocatable :: values(:)    !! In the order of BELIEFS
        type(noise_test_t), allocatable :: noises(:)    !! In the order of NOISE_SUBJECTS
        type(explanation_t), allocatable :: explanations(:)
        !! Of contradictions, those that the data cannot tell apart; empty: none was looked for or found
        integer :: largest(3) = 0
        !! For each component of the offset the place in `values` of the belief with the largest undetected effect
        integer :: largest_within(3) = 0    !! The same if what the operator states holds
    contains
        procedure :: undetected     !! The largest undetected effect on each component
        procedure :: has_contradiction  !! Is any belief contradicted?
        procedure :: how_many       !! Tests, or those with a result
        procedure :: is_untested    !! Cannot some belief be tested here that matters?
        procedure :: take_score     !! Another score for a value
        procedure :: add_untested   !! What no test can see
        procedure :: power_at       !! Of a test whose score has an expectation
        procedure :: noise_factor   !! By which noise is larger than believed, where that is seen; else 1
    end type belief_report_t

contains

    !> An empty report of a fit; its tests are to be added.
    subroutine begin_report(offset, wanted, signs_known, report)
        real(dp), intent(in) :: offset(3)   !! Estimated, m
        real(dp), intent(in) :: wanted      !! Accuracy, m
        logical, intent(in) :: signs_known    !! The sign of the accelerometer has been confirmed
        type(belief_report_t), intent(inout) :: report

        report%offset = offset
        report%wanted = wanted
        report%signs_known = signs_known
        allocate (report%values(0), report%noises(0), report%explanations(0))
    end subroutine begin_report

    !> A belief with a value, from its score, the information that the other parameters leave of it (0: none), what the
    !> operator states of it and what a value of 1 does to the offset.
    !>
    !> Of one that is all or nothing the score is the root of twice the logarithm of the likelihood ratio, 0 where
    !> nothing is as likely: 2 g - S for the value 1. It exceeds c with no more than the probability of a normal variable.
    subroutine add_value(report, belief, score, information, stated, scatter, by_one, largest, conceivable, all_or_nothing)
        type(belief_report_t), intent(inout) :: report
        integer, intent(in) :: belief       !! The parameter's place
        real(dp), intent(in) :: score       !! In 1/unit
        real(dp), intent(in) :: information !! In 1/unit^2
        real(dp), intent(in) :: stated      !! Standard deviation; 0: none
        real(dp), intent(in) :: scatter     !! Of the value by what is stated of it and all others, standard deviation
        real(dp), intent(in) :: by_one(3)   !! m/unit
        real(dp), intent(in) :: largest     !! Conceivable wrong value
        real(dp), intent(in) :: conceivable !! The same within what the operator states
        logical, intent(in) :: all_or_nothing   !! The only one

        type(value_test_t) :: test

        test%belief = belief
        test%subject = belief_subject(belief)
        test%largest = largest
        test%stated = conceivable
        test%all_or_nothing = all_or_nothing
        test%effect = by_one
        if (information > 0) then
            test%value = score/information
            test%sigma = 1/sqrt(information)
            test%score = test%value/hypot(test%sigma, stated)
            test%detectable = hypot(test%sigma, scatter)
            if (all_or_nothing) then
                test%score = sqrt(max(0.0_dp, information*largest*(2*test%value - largest)))
                test%detectable = hypot(test%sigma, stated)
                test%fair = test%score
            else
                test%fair = test%value/test%detectable
            end if
            test%shift = by_one*test%value
        end if
        report%values = [report%values, test]
    end subroutine add_value

    !> A noise, from the sum of squares and its degrees of freedom. The cube root of a chi-square over its degrees of
    !> freedom is nearly normal (E. B. Wilson, M. M. Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684-688).
    subroutine add_noise(report, subject, squares, freedom)
        type(belief_report_t), intent(inout) :: report
        integer, intent(in) :: subject      !! Place in NOISE_SUBJECTS
        real(dp), intent(in) :: squares, freedom    !! Sum of whitened squares; its degrees of freedom

        type(noise_test_t) :: test
        real(dp) :: variance

        if (.not. freedom > 1) return
        test%subject = subject
        test%factor = sqrt(squares/freedom)
        test%gain = (squares - freedom*(1 + log(max(squares/freedom, tiny(1.0_dp)))))/2
        variance = 2/(9*freedom)
        test%significance = ((squares/freedom)**(1/3.0_dp) - (1 - variance))/sqrt(variance)
        test%score = test%significance*sqrt(variance/(variance + (NOISE_KNOWN*2/3)**2))
        report%noises = [report%noises, test]
    end subroutine add_noise

    !> A test of the residuals by a standard normal variable.
    subroutine add_score(report, subject, score, frequency, at_a_rod)
        type(belief_report_t), intent(inout) :: report
        integer, intent(in) :: subject      !! Place in NOISE_SUBJECTS
        real(dp), intent(in) :: score    !! Standard normal if nothing is wrong
        real(dp), intent(in) :: frequency   !! Of a line, Hz; else 0
        logical, intent(in) :: at_a_rod     !! A rod has it

        type(noise_test_t) :: test

        test%subject = subject
        test%score = score
        test%frequency = frequency
        test%at_a_rod = at_a_rod
        report%noises = [report%noises, test]
    end subroutine add_score

    !> Judges the tests, now that their number is known.
    subroutine finish_report(report)
        type(belief_report_t), intent(inout) :: report

        real(dp) :: factor, likelier    ! of a standard deviation: what is found with the power
        real(dp) :: unseen              ! wrong value
        integer :: i, n

        n = size(report%values) + size(report%noises)
        report%critical = normal_quantile(1 - (1 - (1 - FAMILY_LEVEL)**(1.0_dp/max(1, n)))/2)
        associate (beta => normal_quantile(POWER))
            factor = report%critical + beta
            likelier = beta + sqrt(beta**2 + report%critical**2)
        end associate
        do i = 1, size(report%values)
            associate (test => report%values(i))
                unseen = test%largest
                if (test%sigma > 0) then
                    test%detectable = merge(likelier, factor, test%all_or_nothing)*test%detectable
                    unseen = min(unseen, test%detectable)
                    if (test%all_or_nothing .and. test%detectable < test%largest) unseen = 0    ! it would be seen
                end if
                test%unseen = unseen
                test%effect = test%effect*unseen
            end associate
        end do
        call weigh_values(report)
        do i = 1, size(report%noises)
            if (abs(report%noises(i)%score) > report%critical) report%noises(i)%state = CONTRADICTED
        end do
    end subroutine finish_report

    !> What follows from scores and unseen errors: effects within what is stated, states, and which are largest.
    pure subroutine weigh_values(report)
        type(belief_report_t), intent(inout) :: report

        integer :: i, axis

        do i = 1, size(report%values)
            associate (test => report%values(i))
                test%within = test%effect
                if (test%unseen > test%stated .and. max(abs(test%score), beside_the_fit(report, test%belief)) <= SUSPICIOUS) &
                    test%within = test%effect*(test%stated/test%unseen)
                if (abs(test%score) > SUSPICIOUS) test%within = max(abs(test%within), abs(test%shift))
                test%state = CONFIRMED
                if (any(abs(test%within) > report%wanted)) test%state = UNTESTED
                if (abs(test%fair) > report%critical) test%state = CONTRADICTED
            end associate
        end do
        if (size(report%values) == 0) return
        do axis = 1, 3
            report%largest(axis) = maxloc(abs(report%values%effect(axis)), 1)
            report%largest_within(axis) = maxloc(abs(report%values%within(axis)), 1)
        end do
    end subroutine weigh_values

    !> How far the instrument that a belief is of is off what it is compared with beside the fit: the magnetometer off the
    !> field model, the star-camera heads off each other. The size of a score; 0 for all else, and where not compared.
    pure real(dp) function beside_the_fit(report, belief) result(score)
        type(belief_report_t), intent(in) :: report
        integer, intent(in) :: belief       !! The parameter's place

        integer :: subject

        subject = 0
        if (any(belief == FIELD_BIAS) .or. IS_OF_FIELD(belief)) subject = FIELD_AGAINST_MODEL
        if (any(belief == [MOUNTING_1, MOUNTING_2])) subject = HEADS_APART
        score = maxval([0.0_dp, pack(abs(report%noises%score), report%noises%subject == subject)])
    end function beside_the_fit

    !> Takes another score for that of a value.
    pure subroutine take_score(self, i, score)
        class(belief_report_t), intent(inout) :: self
        integer, intent(in) :: i            !! Place in `values`
        real(dp), intent(in) :: score       !! Standard normal if the belief is right

        associate (test => self%values(i))
            if (abs(test%score) > 0) then
                test%fair = test%fair*(score/test%score)
            else
                test%fair = score
            end if
            test%score = score
        end associate
        call weigh_values(self)
    end subroutine take_score

    !> Adds to a finished report an error that no test can see, with no number of tests more.
    pure subroutine add_untested(self, like, subject, by_one, largest, conceivable)
        class(belief_report_t), intent(inout) :: self
        integer, intent(in) :: like         !! Place of a parameter of its kind
        character(*), intent(in) :: subject !! What it is of, in words
        real(dp), intent(in) :: by_one(3)   !! What an error of 1 does to the offset, m
        real(dp), intent(in) :: largest     !! Conceivable error, SI units
        real(dp), intent(in) :: conceivable !! The same within what the operator states

        type(value_test_t) :: test

        test%belief = like
        test%subject = subject
        test%largest = largest
        test%unseen = largest
        test%stated = min(conceivable, largest)
        test%effect = by_one*largest
        self%values = [self%values, test]
        call weigh_values(self)
    end subroutine add_untested

    !> The probability that a test contradicts a belief, from the expectation of its score.
    elemental real(dp) function power_at(self, score) result(probability)
        class(belief_report_t), intent(in) :: self
        real(dp), intent(in) :: score       !! Expected

        probability = erfc((self%critical - abs(score))/sqrt(2.0_dp))/2
    end function power_at

    !> The largest effect on each component of the offset that no test sees, and what the estimate differs from that of
    !> `optimal` by, m.
    pure function undetected(self, within) result(effect)
        class(belief_report_t), intent(in) :: self
        logical, intent(in) :: within       !! If what the operator states holds
        real(dp) :: effect(3)

        integer :: axis

        effect = self%apart
        do axis = 1, 3
            if (size(self%values) == 0) exit
            associate (test => self%values(merge(self%largest_within(axis), self%largest(axis), within)))
                effect(axis) = effect(axis) + abs(merge(test%within(axis), test%effect(axis), within))
            end associate
        end do
    end function undetected

    pure integer function how_many(self, state) result(number)
        class(belief_report_t), intent(in) :: self
        integer, intent(in), optional :: state      !! One of the three; absent: all

        number = size(self%values) + size(self%noises)
        if (present(state)) number = count(self%values%state == state) + count(self%noises%state == state)
    end function how_many

    pure logical function is_untested(self)
        class(belief_report_t), intent(in) :: self

        is_untested = any(self%values%state == UNTESTED) .or. .not. self%signs_known
    end function is_untested

    pure real(dp) function noise_factor(self) result(factor)
        class(belief_report_t), intent(in) :: self

        integer :: i

        factor = 1
        do i = 1, size(self%noises)
            if (self%noises(i)%significance > self%critical) factor = max(factor, self%noises(i)%factor)
        end do
    end function noise_factor

    pure logical function has_contradiction(self)
        class(belief_report_t), intent(in) :: self

        has_contradiction = any(self%values%state == CONTRADICTED) .or. any(self%noises%state == CONTRADICTED)
    end function has_contradiction
end module gracecg_estimation_belief_report
